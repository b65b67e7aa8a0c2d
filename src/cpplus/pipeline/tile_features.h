#pragma once

#include <optional>

#include "cpplus/cloud/map_tiles.h"
#include "cpplus/cloud/point_map.h"
#include "cpplus/cloud/tile_features.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

/// Edges of a tile are kept this far beyond its borders, metres: farther than the same edge found from either side of
/// a border can lie apart, so that one along a border is in one of both tiles at least.
inline constexpr double kTileEdgeOverlapM = 0.05;

/// Planes and edges of a tile. They are looked for in the tile and the roots within halo_m of it; a plane belongs to
/// every tile that it has points in, an edge to every tile that it comes into. `noise_m`: the range noise of the map,
/// which is to be the same for all of its tiles; unknown, it is that of what is looked at. A tile that is the whole map
/// has the features of extract_map_features(). Advances the progress by kMapSteps. Throws Error where the map's indices
/// are damaged.
TileFeatures find_tile_features(const PointMap& points, const MapTile& tile, double halo_m,
                                std::optional<double> noise_m, const RefineImagesOptions& options, Progress* progress);

/// The range noise of a map of any size: all of its roots tell it, or 2048 spread over it evenly where there are more.
double sampled_noise_m(const VoxelMap& map, const PlaneSegmentationOptions& options);

}  // namespace cpplus
