#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Whether one of the leaves in a node of a layer is marked; `marked` by leaf, 0 or 1.
bool has_marked_leaf(const VoxelMap& map, int layer, uint32_t node, const std::vector<uint8_t>& marked);

/// The marked nodes of a layer and the existing ones among the 26 around each; both by node, 0 or 1.
std::vector<uint8_t> with_nodes_around(const VoxelMap& map, int layer, const std::vector<uint8_t>& marked);

/// The nodes of a layer that have dynamic leaves (label 1) in them, and those around them; by node, 0 or 1.
std::vector<uint8_t> nodes_near_dynamic(const VoxelMap& map, int layer, const std::vector<uint8_t>& leaf_labels);

}  // namespace cpplus
