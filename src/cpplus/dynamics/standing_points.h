#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Things that move stand on something: the leaves of their feet and wheels hold ground as well, which many scans hit
/// and none sees through, so that no vote on leaves finds them. In each static leaf near dynamic ones (within the
/// 3 x 3 x 3 voxels of the layer above the leaves) the scans that hit those are compared with the plane through what
/// all other scans hit around it, in the smallest of the voxels 2 and 3 layers above the leaves where that is a plane:
/// their points that stand out of it by min_height_m or more, towards their sensor, become dynamic in `labels` (by
/// point of the scans). `leaf_labels`: 1 = dynamic. Returns how many points. Time is linear in the points of the leaves
/// looked at.
size_t label_standing_points(const VoxelMap& map, const ScanSet& scans, const std::vector<uint8_t>& leaf_labels,
                             double min_height_m, std::vector<uint8_t>* labels);

}  // namespace cpplus
