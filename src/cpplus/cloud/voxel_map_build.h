#pragma once

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/cloud/voxel_map_arrays.h"

namespace cpplus {

/// Nodes with at most this many points have no stored moments: VoxelMap::statistics sums their points instead. It
/// bounds both the bytes a point that sparse clouds cost (36 / 16 a layer) and the work of a query.
inline constexpr uint32_t max_points_without_moments = 16;

/// Builds the arrays of a voxel map in time linear in the points: a stable counting sort by root, then a radix sort by
/// Morton code inside each root, whose points fit in the cache; nodes and moments are gathered from there. The result
/// does not depend on the number of threads.
///
/// Throws Error where a point lies beyond the limit of the voxel keys, or where there are too many points.
VoxelMapArrays build_voxel_map(const PointCloud& cloud, const VoxelMapOptions& options);

}  // namespace cpplus
