#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// One normal for each node of one layer of a map.
struct SurfaceNormals {
  int layer = 0;
  /// Unit, map frame, sign arbitrary; zero where the points of the node do not lie on a plane.
  std::vector<Eigen::Vector3f> of_node;
};

/// Fits a plane to each node of the finest layer whose voxels are at least voxel_size_m large (the roots where none
/// is). A node counts as planar when it has at least six points and the variance across the plane is below a fifth of
/// the middle one.
SurfaceNormals estimate_surface_normals(const VoxelMap& map, double voxel_size_m);

}  // namespace cpplus
