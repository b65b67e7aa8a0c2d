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

}  // namespace cpplus
