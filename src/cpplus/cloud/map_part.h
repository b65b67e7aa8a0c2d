#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Roots of the map that come within radius_m of one of the places (map frame, metres), ascending.
std::vector<uint32_t> roots_near(const VoxelMap& map, std::span<const Eigen::Vector3d> places_in_map, double radius_m);

/// The points in some roots (ascending) of a map, as a map of its own in memory: the one that is built of these points
/// alone, in the order of the input, about the same origin. Of a mapped file only what belongs to these roots is read.
/// With all roots it is the map itself, not a copy. Throws Error where the map's indices are damaged.
PointMap part_of_map(const PointMap& points, std::span<const uint32_t> roots);

}  // namespace cpplus
