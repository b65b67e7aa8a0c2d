#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"
#include "cpplus/dynamics/leaf_surfaces.h"

namespace cpplus {

/// By leaf.
struct SeeThrough {
  /// How many scans see through the leaf: a ray of the scan passes it, ends well behind it, and the scan hits neither
  /// the leaf nor what is beside it. Counted up to sufficient_scans().
  std::vector<uint32_t> num_through;
  /// How many do, or have such a ray within near_radius_m of the leaf's mean. Leaves off planes that one scan alone
  /// hits have such a count, until num_through is sufficient, all others 0: far from the sensors beams are too far
  /// apart to pass what one of them hit.
  std::vector<uint32_t> num_near;
};

/// One ray a scan and leaf that it hits. `surfaces` are those of map and scans.
SeeThrough count_see_through(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                             const DynamicsOptions& options);

}  // namespace cpplus
