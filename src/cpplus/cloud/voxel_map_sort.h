#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/cloud/voxel_map_buffer.h"

namespace cpplus {

/// Points grouped by root voxel, roots ascending by key, points of a root in the order of the input.
struct PointsByRoot {
  size_t num_points = 0;  // the finite ones
  Buffer<Eigen::Vector3f> positions;
  Buffer<uint32_t> input_indices;
  std::vector<Eigen::Vector3i> root_keys;
  std::vector<uint32_t> points_begin;  // roots + 1
};

/// Stable counting sort by root, parallel over chunks of the input; non-finite points are left out. Throws Error where
/// a point lies beyond the limit of the voxel keys, or where there are too many points for 32-bit indices.
PointsByRoot sort_points_by_root(const PointCloud& cloud, const VoxelMapOptions& options);

}  // namespace cpplus
