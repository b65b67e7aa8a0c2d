#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"

namespace cpplus {

/// What one scan hits in one place is one thing: of a person, too far away for all of him to be seen through, what is
/// tells about the rest. A static leaf becomes dynamic when, of each scan that hits it, at least two leaves and a share
/// of `fill_share` of those that the scan hits around are dynamic. *Around* are the 3 x 3 x 3 voxels of the third layer
/// above the leaves. Leaves that more than twice as many scans hit as any dynamic one around are something else, such
/// as the ground, and have no say.
///
/// `labels` (1 = dynamic) and `num_scans`, of those that hit it, by leaf. Returns the labels after that.
std::vector<uint8_t> fill_by_scan(const VoxelMap& map, const ScanSet& scans, const std::vector<uint32_t>& num_scans,
                                  const std::vector<uint8_t>& labels, const DynamicsOptions& options);

}  // namespace cpplus
