#include "cpplus/colorize/color_samples.h"

#include <algorithm>
#include <limits>

namespace cpplus {

ColorSamples::ColorSamples(size_t num_points, int max_samples)
    : max_samples_(max_samples),
      samples_(num_points * static_cast<size_t>(max_samples)),
      num_kept_(num_points, 0),
      num_views_(num_points, 0) {}

void ColorSamples::add(size_t point, const ColorSample& sample) {
  if (num_views_[point] < std::numeric_limits<uint16_t>::max()) ++num_views_[point];
  ColorSample* kept = &samples_[point * static_cast<size_t>(max_samples_)];
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

void ColorSamples::renumber_images(std::span<const uint16_t> new_index) {
  for (size_t point = 0; point < num_points(); ++point) {
    ColorSample* kept = &samples_[point * static_cast<size_t>(max_samples_)];
    for (uint8_t k = 0; k < num_kept_[point]; ++k) kept[k].image = new_index[kept[k].image];
  }
}

void ColorSamples::restore(size_t point, std::span<const ColorSample> kept, uint16_t num_views) {
  std::copy(kept.begin(), kept.end(),
            samples_.begin() + static_cast<ptrdiff_t>(point * static_cast<size_t>(max_samples_)));
  num_kept_[point] = static_cast<uint8_t>(kept.size());
  num_views_[point] = num_views;
}

}  // namespace cpplus
