#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

struct PointTileOptions {
  /// A tile with more points is divided into the tiles of its octants.
  size_t max_points = 60000;
  /// The points of a tile that is divided are one a voxel; so many voxels fit along its edge. A power of two.
  int voxels_along_edge = 128;
};

/// A cube of a point cloud in one level of detail.
struct PointTile {
  Eigen::Vector3d corner_in_map;   // the least of the cube's corners
  double size_m = 0.0;             // edge of the cube
  double spacing_m = 0.0;          // edge of the voxels that one point each stands for; 0 = every point is there
  std::vector<VoxelNode> nodes;    // whose points they are; those of a cube larger than the map's roots are roots
  std::vector<uint32_t> children;  // tiles, finer, which replace this one
};

/// Layers of the voxel map as tiles for a viewer. Cubes of the size of roots, halves, quarters, ... are nodes of the
/// map; larger ones join roots, counted from the least one, until one cube holds everything, the last tile of the
/// result. Children come before parents. The map must have voxels_along_edge times smaller leaves than roots.
std::vector<PointTile> plan_point_tiles(const VoxelMap& map, const PointTileOptions& options);

/// The points of a tile, relative to `origin_in_map`, metres: all of them, or the mean of each voxel, with the mean of
/// the colours of its points. Where some points of a voxel are coloured the others do not count.
struct TilePoints {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Rgb> colors;
};

/// `colors` and `is_colored` by input index of the map.
TilePoints gather_tile_points(const VoxelMap& map, const PointTile& tile, const std::vector<Rgb>& colors,
                              const std::vector<uint8_t>& is_colored, const Eigen::Vector3d& origin_in_map);

}  // namespace cpplus
