#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/tile_features.h"

namespace cpplus {

/// Planes of several tiles: those that go on from one tile to the next are one.
struct JoinedPlanes {
  std::vector<MapPlane> planes;
  /// For each tile: the numbers of its planes.
  std::vector<std::vector<int32_t>> number_of;
  double noise_m = 0.0;  // mean of the tiles', by their points
};

/// See join_tiles().
JoinedPlanes join_tile_planes(const std::vector<TileFeatures>& tiles);

}  // namespace cpplus
