#pragma once

#include <vector>

#include "cpplus/cloud/map_tiles.h"
#include "cpplus/cloud/tile_features.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

/// The features of some tiles of a map as those of one map.
///
/// Planes of neighbouring tiles are one where they hold the same points of the leaves around the border, as long as one
/// plane fits the points of both; it is fitted to these. Of edges that two tiles hold both, which lie at most
/// 5 cm apart, the part in the later one is given up, and what is left belongs to the same group.
///
/// `near`, the map of some `roots` (ascending) of `map`; every one of them is in one of the tiles, `tiles[t]` with
/// features[t]. Planes without points in these roots are left out. Features of one tile that is the whole map are
/// those of extract_map_features(), bit for bit.
MapFeatures join_tiles(const VoxelMap& map, const VoxelMap& near, const std::vector<uint32_t>& roots,
                       const std::vector<const MapTile*>& tiles, const std::vector<TileFeatures>& features,
                       const RefineImagesOptions& options);

}  // namespace cpplus
