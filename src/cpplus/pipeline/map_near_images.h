#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

/// What a command needs of a map of which its images see a part.
struct NearMap {
  PointMap points;              // of these roots alone, in memory; the map itself where that is all of it
  std::vector<uint32_t> roots;  // of the map, ascending
};

/// The roots within reach_m of any of the places (map frame), ascending; all of them where these hold most of the map.
std::vector<uint32_t> roots_near_places(const VoxelMap& map, const std::vector<Eigen::Vector3d>& places,
                                        double reach_m);

/// The part of some roots (ascending). Throws Error naming the file `path` of the map where its indices are damaged.
NearMap part_near(const std::string& path, const PointMap& points, std::vector<uint32_t> roots);

/// The part of the roots within reach_m of any of the places, likewise.
NearMap map_near_places(const std::string& path, const PointMap& points, const std::vector<Eigen::Vector3d>& places,
                        double reach_m);

/// Where the images of a model were taken, map frame.
std::vector<Eigen::Vector3d> camera_centers(const SparseModel& model);

}  // namespace cpplus
