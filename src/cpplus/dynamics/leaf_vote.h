#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"
#include "cpplus/dynamics/leaf_surfaces.h"
#include "cpplus/dynamics/see_through.h"

namespace cpplus {

/// So many scans of `num_scans` that see through a leaf that num_hits hit settle its label; more change nothing.
uint32_t sufficient_scans(uint32_t num_hits, size_t num_scans, const DynamicsOptions& options);

/// Labels the leaves, 1 = dynamic: each from the numbers of scans that see through it or beside it, that hit it, and
/// that hit something around it (count_region_hits); those of which that is not sure by keep_with_neighbors(), too.
std::vector<uint8_t> vote_on_leaves(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                    const SeeThrough& seen, const DynamicsOptions& options);

/// Dynamic leaves that are not sure become static where less than `keep_share` of the others in the 3 x 3 x 3 voxels of
/// the layer above the leaves are dynamic. `labels` and `is_sure` by leaf.
std::vector<uint8_t> keep_with_neighbors(const VoxelMap& map, const std::vector<uint8_t>& labels,
                                         const std::vector<uint8_t>& is_sure, double keep_share);

}  // namespace cpplus
