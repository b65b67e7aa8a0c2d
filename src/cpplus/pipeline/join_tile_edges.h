#pragma once

#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/map_tiles.h"
#include "cpplus/cloud/tile_features.h"

namespace cpplus {

/// The edges of several tiles, `tiles[t]` with features[t]; see join_tiles(). Groups are distinct.
std::vector<MapEdge> join_tile_edges(const std::vector<const MapTile*>& tiles,
                                     const std::vector<TileFeatures>& features);

}  // namespace cpplus
