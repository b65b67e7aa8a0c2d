#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"
#include "cpplus/dynamics/leaf_surfaces.h"

namespace cpplus {

/// So many scans of `num_scans` that see through a leaf that num_hits hit settle its label; more change nothing.
uint32_t sufficient_scans(uint32_t num_hits, size_t num_scans, const DynamicsOptions& options);

/// Labels the leaves, 1 = dynamic: first each from the numbers of scans that see through it, that hit it, and that hit
/// something around it (count_region_hits), then by vote_with_neighbors().
std::vector<uint8_t> vote_on_leaves(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                    const std::vector<uint32_t>& num_through, const DynamicsOptions& options);

/// Revises the labels of leaves with the word of the leaves around, which are those in the 3 x 3 x 3 voxels of the
/// layer above the leaves.
std::vector<uint8_t> vote_with_neighbors(const VoxelMap& map, const std::vector<uint8_t>& first,
                                         const std::vector<uint32_t>& num_hits,
                                         const std::vector<uint32_t>& num_through, const DynamicsOptions& options);

}  // namespace cpplus
