#pragma once

#include <string>

#include "cpplus/cloud/point_map.h"
#include "cpplus/io/cloud_builder.h"

namespace cpplus {

/// Reads the map that a command is given: a point cloud (.pcd .ply .las), whose voxel map is built in memory, or a
/// voxel map file (.vox), which is mapped. A .vox keeps the sizes that it was built with: throws Error where `options`
/// ask for others that are not the defaults, and naming the file for what cannot be read.
PointMap read_map(const std::string& path, const VoxelMapOptions& options);

/// The points of such a file alone, in memory, in the order in which they came (those of all files one after the other
/// that a .vox was made of).
PointCloud read_map_cloud(const std::string& path);

}  // namespace cpplus
