#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/visibility/leaf_truth.h"

namespace cpplus::bench {

/// One camera in an indoor map, the leaves that all methods choose from, and the truth.
struct View {
  VoxelMap map;
  Camera camera;
  Rigid3 camera_from_map;
  std::vector<uint32_t> candidates;          // in the image and within 20 m, ascending
  std::vector<Eigen::Vector3d> x_in_camera;  // centres of the candidates
  std::vector<LeafTruth> truth;              // per leaf of the map
  std::vector<uint32_t> neighborhood;        // leaves within 20 m all around, ascending
  std::vector<Eigen::Vector3d> neighborhood_x_in_camera;
};

void register_open3d(const View& view);

}  // namespace cpplus::bench
