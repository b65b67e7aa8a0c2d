#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// A plane as one tile of a map knows it.
struct TilePlane {
  MapPlane plane;       // fitted to its points in the tile and around it
  VoxelStatistics own;  // of its points in the tile
};

/// The points of one plane in one leaf.
struct PlanePatch {
  uint32_t leaf = 0;                                 // of the whole map
  int32_t plane = 0;                                 // of the tile
  Eigen::Vector3f center = Eigen::Vector3f::Zero();  // mean of the points, relative to the map's origin, metres
};

/// Planes and edges of one tile of a map (cloud/map_tiles.h), found with what lies around it, so that those of
/// neighbouring tiles fit together.
struct TileFeatures {
  double noise_m = 0.0;  // range noise, standard deviation
  uint64_t num_points = 0;
  std::vector<TilePlane> planes;           // that have points in the tile
  std::vector<PlanePatch> patches;         // of the tile's leaves, in the order of the leaves
  std::vector<PlanePatch> patches_around;  // of leaves near the border in other tiles, likewise
  std::vector<MapEdge> edges;              // that come into the tile's box or near it; they may end beyond
  std::vector<float> leaf_spacing;         // of the tile's leaves (visibility/point_spacing.h), metres
};

}  // namespace cpplus
