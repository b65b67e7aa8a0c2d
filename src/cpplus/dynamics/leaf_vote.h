#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"

namespace cpplus {

/// So many scans that see through a leaf that num_hits hit settle its label; more change nothing.
uint32_t sufficient_scans(uint32_t num_hits, const DynamicsOptions& options);

/// Labels the leaves, 1 = dynamic: first each by itself, from the numbers of scans that hit it and that see through it,
/// then with the word of the leaves around, which are those in the 3 x 3 x 3 voxels of the layer above the leaves.
std::vector<uint8_t> vote_on_leaves(const VoxelMap& map, const std::vector<uint32_t>& num_hits,
                                    const std::vector<uint32_t>& num_through, const DynamicsOptions& options);

}  // namespace cpplus
