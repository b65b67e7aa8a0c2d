#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/leaf_surfaces.h"

namespace cpplus {

/// How many scans hit something around each candidate leaf: in the 3 x 3 x 3 voxels of the layer above the leaves, on
/// leaves that lie on no plane, so that the ground below and the wall behind do not count. A thing that stands is hit
/// there by most scans that see the place, one that passed by few. `is_candidate` by leaf; 0 for the others.
std::vector<uint32_t> count_region_hits(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                        const std::vector<uint8_t>& is_candidate);

}  // namespace cpplus
