#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// The existing neighbours of every leaf of a map (up to 26), looked up once for the steps that all need them.
class LeafNeighbors {
 public:
  explicit LeafNeighbors(const VoxelMap& map);

  /// Leaves, ascending, without the leaf itself.
  std::span<const uint32_t> operator[](uint32_t leaf) const {
    return {neighbors_.data() + begin_[leaf], neighbors_.data() + begin_[leaf + 1]};
  }

 private:
  std::vector<uint32_t> begin_;
  std::vector<uint32_t> neighbors_;
};

}  // namespace cpplus
