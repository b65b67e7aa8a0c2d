#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// The marked nodes of a layer and the existing ones among the 26 around each; both by node, 0 or 1.
std::vector<uint8_t> with_nodes_around(const VoxelMap& map, int layer, const std::vector<uint8_t>& marked);

}  // namespace cpplus
