#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"
#include "cpplus/dynamics/leaf_surfaces.h"

namespace cpplus {

/// How many scans see through each leaf: a ray of the scan passes it, ends well behind it, and the scan hits neither
/// the leaf nor what is beside it. One ray a scan and leaf that it hits. `surfaces` are those of map and scans.
std::vector<uint32_t> count_see_through(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                        const DynamicsOptions& options);

}  // namespace cpplus
