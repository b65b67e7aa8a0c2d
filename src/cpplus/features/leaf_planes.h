#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Which planes have points in each leaf of a map.
class LeafPlanes {
 public:
  /// `plane_of_point` in map order; negative where a point lies on no plane.
  LeafPlanes(const VoxelMap& map, const std::vector<int32_t>& plane_of_point);

  /// Plane ids, ascending.
  std::span<const int32_t> operator[](uint32_t leaf) const {
    return {planes_.data() + begin_[leaf], planes_.data() + begin_[leaf + 1]};
  }

 private:
  std::vector<uint32_t> begin_;
  std::vector<int32_t> planes_;
};

}  // namespace cpplus
