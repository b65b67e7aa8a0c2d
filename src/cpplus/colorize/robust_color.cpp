#include "cpplus/colorize/robust_color.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cpplus {
namespace {

using Color = std::array<float, 3>;

bool agree(const Color& a, const Color& b, float max_deviation) {
  return std::abs(a[0] - b[0]) <= max_deviation && std::abs(a[1] - b[1]) <= max_deviation &&
         std::abs(a[2] - b[2]) <= max_deviation;
}

/// Weighted mean of the samples that agree with `center`; `center` where none does.
Color mean_around(std::span<const WeightedColor> samples, const Color& center, float max_deviation) {
  Color sum{};
  float total = 0.0f;
  for (const WeightedColor& sample : samples) {
    if (!agree(sample.color, center, max_deviation)) continue;
    for (size_t c = 0; c < 3; ++c) sum[c] += sample.weight * sample.color[c];
    total += sample.weight;
  }
  if (!(total > 0.0f)) return center;
  for (float& channel : sum) channel /= total;
  return sum;
}

/// The sample with most votes, its own included.
size_t most_supported(std::span<const WeightedColor> samples, float max_deviation) {
  // Of most points all samples agree, and nothing needs to be counted.
  const auto agrees_with_first = [&](const WeightedColor& s) {
    return agree(samples[0].color, s.color, max_deviation);
  };
  if (std::all_of(samples.begin(), samples.end(), agrees_with_first)) return 0;
  std::vector<float> own_votes(samples.size()), votes(samples.size(), 0.0f);
  for (size_t i = 0; i < samples.size(); ++i) {
    own_votes[i] = std::sqrt(samples[i].weight);
    for (size_t j = 0; j < i; ++j) {
      if (!agree(samples[i].color, samples[j].color, max_deviation)) continue;
      votes[i] += own_votes[j];
      votes[j] += own_votes[i];
    }
    votes[i] += own_votes[i];
  }
  return static_cast<size_t>(std::max_element(votes.begin(), votes.end()) - votes.begin());
}

}  // namespace

RobustColor robust_color(std::span<const WeightedColor> samples, double max_deviation) {
  RobustColor result;
  if (samples.empty()) return result;
  const auto deviation = static_cast<float>(max_deviation);
  Color color = samples[most_supported(samples, deviation)].color;
  for (int i = 0; i < 2; ++i) color = mean_around(samples, color, deviation);

  float squares = 0.0f, total = 0.0f, heaviest = -1.0f;
  for (size_t i = 0; i < samples.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const float difference = samples[i].color[c] - color[c];
      squares += samples[i].weight * difference * difference / 3.0f;
    }
    total += samples[i].weight;
    if (samples[i].weight > heaviest && agree(samples[i].color, color, deviation)) {
      heaviest = samples[i].weight;
      result.best = i;
    }
  }
  for (size_t c = 0; c < 3; ++c) {
    result.color[c] = static_cast<uint8_t>(std::lround(std::clamp(color[c], 0.0f, 255.0f)));
  }
  if (total > 0.0f) result.spread = static_cast<uint8_t>(std::lround(std::min(255.0f, std::sqrt(squares / total))));
  return result;
}

}  // namespace cpplus
