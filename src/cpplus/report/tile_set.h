#pragma once

#include <string>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

/// Writes a cloud as a 3D Tiles 1.0 tile set with levels of detail (report/point_tiles.h): FOLDER/tileset.json and
/// FOLDER/tiles/*.pnts, in metres relative to `origin_in_map`. Points without a colour are grey, lighter with more
/// intensity where the cloud has intensities. tileset.json comes last, so that it stands for a whole set. Throws Error
/// where a file cannot be written.
void write_tile_set(const PointCloud& cloud, const Eigen::Vector3d& origin_in_map, const std::string& folder);

/// The middle of the cloud's points, rounded to metres.
Eigen::Vector3d tile_set_origin(const PointCloud& cloud);

}  // namespace cpplus
