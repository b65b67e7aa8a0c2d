#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Some roots of a map that are worked on at a time, and the part of space that is theirs.
struct MapTile {
  std::vector<uint32_t> roots;  // ascending
  /// Map frame, metres; infinite on sides without a neighbour. Every point of space lies in one tile's box, a point on
  /// a border in that of the greater coordinate.
  Eigen::AlignedBox3d box;
};

/// All roots in tiles: all of them in one where the map has at most max_points points, else both halves across their
/// longest extent, halved in turn, but not to less than four roots across. Depends on the map and max_points alone.
std::vector<MapTile> divide_map(const VoxelMap& map, size_t max_points);
/// Some of its roots (ascending) alike; what tiles depend on are these roots alone. None without roots.
std::vector<MapTile> divide_roots(const VoxelMap& map, std::vector<uint32_t> roots, size_t max_points);

/// The roots of a tile and those within halo_m of their bounding box, ascending.
std::vector<uint32_t> roots_around(const VoxelMap& map, const MapTile& tile, double halo_m);

}  // namespace cpplus
