#pragma once

#include <Eigen/Core>

#include "cpplus/cloud/plane_buffer.h"

namespace cpplus {

/// Up to which range anything can be seen around a pixel, on coarse blocks: a quick test by which whole leaves that lie
/// in other rooms are left out. Nothing is hidden around a pixel where one of the cells of the blocks around it shows
/// no plane; so what may be seen beside the rim of a plane is never left out.
class HiddenRanges {
 public:
  /// Without ranges in the buffer nothing is hidden.
  explicit HiddenRanges(const PlaneBuffer& planes);

  /// Whether a leaf of which one point is seen at this pixel (NaN: nowhere) and range lies clearly behind all planes
  /// that are seen around it.
  bool hides(const Eigen::Vector2f& pixel, float range_m) const;

 private:
  float block_px_;
  RangeImage farthest_;  // per block: of the planes in it and in the eight blocks around it, metres
};

}  // namespace cpplus
