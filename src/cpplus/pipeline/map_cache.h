#pragma once

#include <string>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Where to read a map: the voxel map file of a point cloud in the folder `cache`, made there
/// (pipeline/index_command.h) unless one stands there of this file's size and time of change, these sizes of voxels and
/// this version of the format; the map itself where it is a voxel map file already, or `cache` is "". Throws what
/// index_command() throws.
std::string cached_map(const std::string& map, const std::string& cache, const VoxelMapOptions& options);

}  // namespace cpplus
