#include "cpplus/io/map_io.h"

#include <fmt/format.h>

#include "cpplus/core/error.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/voxel_map_file.h"

namespace cpplus {
namespace {

void check_size(const std::string& path, const char* name, double stored, double asked, double default_size) {
  if (asked == stored || asked == default_size) return;
  throw Error(fmt::format("{}: was built with {} {}, not {}: index the map again, or leave the option out", path, name,
                          stored, asked));
}

void check_sizes(const std::string& path, const VoxelMapOptions& stored, const VoxelMapOptions& asked) {
  const VoxelMapOptions defaults;
  check_size(path, "root_size_m", stored.root_size_m, asked.root_size_m, defaults.root_size_m);
  check_size(path, "leaf_size_m", stored.leaf_size_m, asked.leaf_size_m, defaults.leaf_size_m);
}

PointCloud points_of_file(const std::string& path, const PointMap& points) {
  try {
    return cloud_in_input_order(points);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: damaged: {}", path, error.what()));
  }
}

}  // namespace

PointMap read_map(const std::string& path, const VoxelMapOptions& options) {
  if (is_voxel_map_file(path)) {
    PointMap points = map_voxel_map_file(path);
    check_sizes(path, points.map.options(), options);
    return points;
  }
  ReadCounts counts;
  PointMap points = make_point_map(read_point_cloud(path, &counts), options);
  points.num_dropped_non_finite = counts.dropped_non_finite;
  return points;
}

PointCloud read_map_cloud(const std::string& path) {
  return is_voxel_map_file(path) ? points_of_file(path, map_voxel_map_file(path)) : read_point_cloud(path);
}

}  // namespace cpplus
