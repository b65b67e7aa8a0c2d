#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// What one image shows of one point, in 8 bytes.
struct ColorSample {
  Rgb color{};
  uint8_t weight = 0;  // 1..255 for (0, 1]
  uint16_t image = 0;  // index in the order of the views
  uint8_t radius = 0;  // distance from the image centre, 255 = half the diagonal
};

/// A share in [0, 1] as a sample keeps it: smallest..255.
inline uint8_t share_in_8_bits(double share, int smallest) {
  return static_cast<uint8_t>(std::clamp(static_cast<int>(255.0 * share + 0.5), smallest, 255));
}

/// The best few colour samples of each point. Memory is fixed from the start, 8 * max_samples + 3 bytes a point,
/// however many images there are.
class ColorSamples {
 public:
  ColorSamples(size_t num_points, int max_samples);

  /// Offers a sample. A point that is full drops its lightest sample, the later one where two are equally light.
  /// Different points may be added to at the same time.
  void add(size_t point, const ColorSample& sample);

  /// Gives a point without samples what another one had: its kept samples, max_samples at most, and its views.
  void restore(size_t point, std::span<const ColorSample> kept, uint16_t num_views);

  /// Gives all samples the image index that `new_index` has for theirs.
  void renumber_images(std::span<const uint16_t> new_index);

  /// How many images offered a sample, also those not kept.
  uint16_t num_views(size_t point) const { return num_views_[point]; }

  /// The kept samples in the order they came in.
  std::span<const ColorSample> of_point(size_t point) const {
    return {samples_.data() + point * static_cast<size_t>(max_samples_), num_kept_[point]};
  }
  size_t num_points() const { return num_views_.size(); }

 private:
  int max_samples_;
  std::vector<ColorSample> samples_;  // max_samples_ a point
  std::vector<uint8_t> num_kept_;
  std::vector<uint16_t> num_views_;
};

}  // namespace cpplus
