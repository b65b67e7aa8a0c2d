#pragma once

#include <Eigen/Core>
#include <optional>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Where a camera sees a point, and how that pixel moves with the camera.
struct PerturbedPixel {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 6> by_perturbation = Eigen::Matrix<double, 2, 6>::Zero();  // geometry/rigid3.h
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();         // per metre, camera frame
};

/// Nothing where the camera model does not hold.
inline std::optional<PerturbedPixel> project_perturbed(const Camera& camera, const Eigen::Vector3d& x_in_camera) {
  PerturbedPixel p;
  if (!camera.project(x_in_camera, &p.pixel, &p.by_point)) return std::nullopt;
  p.by_perturbation = p.by_point * d_camera_point_d_delta(x_in_camera);
  return p;
}

}  // namespace cpplus
