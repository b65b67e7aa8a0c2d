#pragma once

#include <Eigen/Core>
#include <optional>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/image_pose.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_samples.h"

namespace cpplus {

struct ProjectedSample {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Rigid3 camera_from_map;                             // while the pixel's row is exposed
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // across the projected edge
  /// By the perturbation in geometry/rigid3.h.
  Eigen::Matrix<double, 2, 6> d_pixel_d_delta = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Matrix<double, 2, 3> d_pixel_d_point = Eigen::Matrix<double, 2, 3>::Zero();  // per metre, map frame
};

/// Projects an edge sample (Eq. 3 of Cui & Schwertfeger 2022) with its derivatives. Under a rolling shutter the row in
/// which a point is seen and the pose of that row depend on each other; a few steps of a fixed point find both. Nothing
/// where the camera model does not hold or the edge is seen end-on.
std::optional<ProjectedSample> project_sample(const Camera& camera, const ImagePose& pose, const EdgeSample& sample);

}  // namespace cpplus
