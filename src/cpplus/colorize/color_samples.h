#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// The best few colour samples of each point. Memory is fixed from the start, 4 * max_samples + 3 bytes a point,
/// however many images there are.
class ColorSamples {
 public:
  ColorSamples(size_t num_points, int max_samples);

  /// Offers a sample with a weight in (0, 1] (kept with 8 bits). A point that is full drops its lightest sample, the
  /// later one where two are equally light. Different points may be added to at the same time.
  void add(size_t point, const Rgb& color, double weight);

  /// How many images offered a sample, also those not kept.
  uint16_t num_views(size_t point) const { return num_views_[point]; }

  /// The robust mean of the samples of a point: per channel the weighted median, then the weighted mean of the samples
  /// whose channels all lie within max_deviation grey levels of it. An outlier among three samples has no influence,
  /// yet the noise of the good ones is averaged. (0, 0, 0) for a point without samples.
  Rgb color(size_t point, double max_deviation) const;

 private:
  struct Sample {
    Rgb color;
    uint8_t weight;
  };

  int max_samples_;
  std::vector<Sample> samples_;  // max_samples_ a point
  std::vector<uint8_t> num_kept_;
  std::vector<uint16_t> num_views_;
};

}  // namespace cpplus
