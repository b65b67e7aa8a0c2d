#include "cpplus/colorize/color_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace cpplus {
namespace {

/// Smallest value with at least half of the total weight at or below it; the middle between it and the next one where
/// it is exactly half. `values` is reordered.
double weighted_median(std::vector<std::pair<int, int>>* values) {
  std::sort(values->begin(), values->end());
  int total = 0;
  for (const auto& [value, weight] : *values) total += weight;
  int below = 0;
  for (size_t i = 0; i < values->size(); ++i) {
    below += (*values)[i].second;
    if (2 * below == total) return 0.5 * ((*values)[i].first + (*values)[i + 1].first);
    if (2 * below > total) return (*values)[i].first;
  }
  return 0.0;
}

}  // namespace

ColorSamples::ColorSamples(size_t num_points, int max_samples)
    : max_samples_(max_samples),
      samples_(num_points * static_cast<size_t>(max_samples)),
      num_kept_(num_points, 0),
      num_views_(num_points, 0) {}

void ColorSamples::add(size_t point, const Rgb& color, double weight) {
  if (num_views_[point] < std::numeric_limits<uint16_t>::max()) ++num_views_[point];
  const Sample sample{color, static_cast<uint8_t>(std::clamp(std::lround(255.0 * weight), 1L, 255L))};
  Sample* kept = &samples_[point * static_cast<size_t>(max_samples_)];
  if (num_kept_[point] < max_samples_) {
    kept[num_kept_[point]++] = sample;
    return;
  }
  // The kept samples stay in the order they came in, so that the last of the lightest ones is the latest.
  int lightest = max_samples_ - 1;
  for (int k = max_samples_ - 2; k >= 0; --k) {
    if (kept[k].weight < kept[lightest].weight) lightest = k;
  }
  if (sample.weight <= kept[lightest].weight) return;
  std::move(kept + lightest + 1, kept + max_samples_, kept + lightest);
  kept[max_samples_ - 1] = sample;
}

Rgb ColorSamples::color(size_t point, double max_deviation) const {
  const Sample* begin = samples_.data() + point * static_cast<size_t>(max_samples_);
  const Sample* end = begin + num_kept_[point];
  if (begin == end) return {};

  std::array<double, 3> median;
  std::vector<std::pair<int, int>> values;
  for (size_t c = 0; c < 3; ++c) {
    values.clear();
    for (const Sample* s = begin; s != end; ++s) values.emplace_back(s->color[c], s->weight);
    median[c] = weighted_median(&values);
  }

  std::array<double, 3> sum{};
  double total = 0.0;
  for (const Sample* s = begin; s != end; ++s) {
    bool agrees = true;
    for (size_t c = 0; c < 3; ++c) agrees = agrees && std::abs(s->color[c] - median[c]) <= max_deviation;
    if (!agrees) continue;
    for (size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(s->weight) * s->color[c];
    total += s->weight;
  }
  Rgb result;
  for (size_t c = 0; c < 3; ++c)
    result[c] = static_cast<uint8_t>(std::lround(total > 0.0 ? sum[c] / total : median[c]));
  return result;
}

}  // namespace cpplus
