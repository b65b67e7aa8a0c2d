#include "cpplus/features/leaf_planes.h"

#include <algorithm>

namespace cpplus {

LeafPlanes::LeafPlanes(const VoxelMap& map, const std::vector<int32_t>& plane_of_point) {
  const uint32_t num_leaves = map.num_nodes(map.leaf_layer());
  begin_.reserve(num_leaves + 1);
  begin_.push_back(0);
  for (uint32_t leaf = 0; leaf < num_leaves; ++leaf) {
    const auto first = static_cast<std::ptrdiff_t>(planes_.size());
    for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
      const int32_t id = plane_of_point[i];
      if (id >= 0 && std::find(planes_.begin() + first, planes_.end(), id) == planes_.end()) planes_.push_back(id);
    }
    std::sort(planes_.begin() + first, planes_.end());
    begin_.push_back(static_cast<uint32_t>(planes_.size()));
  }
}

}  // namespace cpplus
