#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/cloud/plane_buffer.h"

namespace cpplus {

/// Up to which range anything can be seen around a pixel, on coarse blocks: a quick test by which whole nodes of the
/// map that lie in other rooms are left out. Nothing is hidden around a pixel where one of the cells of the blocks
/// around it shows no plane; so what may be seen beside the rim of a plane is never left out.
class HiddenRanges {
 public:
  /// Nothing is hidden.
  HiddenRanges() = default;
  /// Without ranges in the buffer nothing is hidden.
  explicit HiddenRanges(const PlaneBuffer& planes);

  /// Whether all points within radius_m of one that is seen at this pixel (NaN: nowhere) and range lie clearly behind
  /// all planes that are seen around them.
  bool hides(const Eigen::Vector2f& pixel, float range_m, float radius_m) const;

 private:
  // Of blocks of one size: up to which range anything can be seen in each and in the eight around it, metres.
  struct Level {
    float block_px;
    RangeImage farthest;
  };

  float pixels_per_radian_ = 0.0f;
  std::vector<Level> levels_;  // from small blocks to large ones
};

}  // namespace cpplus
