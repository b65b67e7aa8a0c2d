#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/refine/projected_sample.h"

namespace cpplus {

/// A sample of a map edge and the image edge that it matches.
struct EdgeMatch {
  /// Under a rolling shutter the place where the middle row's pose sees the point as the pose of its own row does.
  Eigen::Vector3d x_in_map = Eigen::Vector3d::Zero();
  double row_fraction = 0.0;                          // of the image edge (geometry/image_pose.h)
  uint32_t edge = 0;                                  // index of the MapEdge
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();    // of the image edge
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // unit, across the projected map edge
  double sigma_px = 1.0;                              // of this residual alone
  double weight = 1.0;                                // < 1: its share of what its edge can know
  /// Along the edge; standard deviation of how far the point seems to leave the edge, pixels, when it moves by a metre
  /// along it, since the edge's direction is not known better.
  Eigen::Vector3d slip_in_map = Eigen::Vector3d::Zero();
  ProjectedSample projected;
};

/// How many map edges have a match; matches ordered by edge.
int count_edges(const std::vector<EdgeMatch>& matches);

/// Information of the perturbation (geometry/rigid3.h) that the matches hold, each with the weight that Cauchy's loss
/// of that scale leaves it, less what errors of the edges' directions feign (direction_errors.h).
Matrix6d edge_information(const std::vector<EdgeMatch>& matches, double loss_scale);

}  // namespace cpplus
