#pragma once

#include <optional>
#include <span>

#include "cpplus/core/image.h"

namespace cpplus {

/// The greys of points that no image shows, from their intensities: proportional to them, with the 99th percentile of a
/// cloud darker than most of what images show, so that points without a colour do not look like white walls.
class GrayScale {
 public:
  /// Mid-grey for all.
  GrayScale() = default;
  /// Of a cloud's intensities (may be empty). Exact, in memory that does not depend on their number.
  explicit GrayScale(std::span<const float> intensities);

  /// Mid-grey where no intensity of the cloud is above zero, or this one is not finite.
  Rgb gray(float intensity) const;
  Rgb gray() const;
  /// Of point i of a cloud with these intensities (may be empty).
  Rgb gray_of_point(std::span<const float> intensities, size_t i) const {
    return intensities.empty() ? gray() : gray(intensities[i]);
  }

 private:
  std::optional<double> brightest_;
};

}  // namespace cpplus
