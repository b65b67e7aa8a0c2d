#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Parts of a set of images that lie near each other: all of them where the map within reach_m of them holds at most
/// max_points points, else both halves across their longest extent, halved in turn. Images whose halves would have
/// nearly the same around them stay one group however much that is. Indices of the places (map frame), ascending in
/// each group; every index is in one group.
std::vector<std::vector<size_t>> group_images(const VoxelMap& map, const std::vector<Eigen::Vector3d>& places,
                                              double reach_m, size_t max_points);

}  // namespace cpplus
