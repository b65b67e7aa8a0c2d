#pragma once

#include <Eigen/Cholesky>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// What is known of a pose before its image is looked at: a Gaussian around `camera_from_map`.
struct PoseGuess {
  Rigid3 camera_from_map;
  Matrix6d covariance = Matrix6d::Identity();  // of the perturbation in geometry/rigid3.h: rad, rad, rad, m, m, m

  PoseGuess() = default;
  PoseGuess(const Rigid3& mean, const Matrix6d& its_covariance) : camera_from_map(mean), covariance(its_covariance) {}
  PoseGuess(const Rigid3& mean, const Vector6d& sigmas)
      : camera_from_map(mean), covariance(sigmas.cwiseAbs2().asDiagonal()) {}

  Vector6d sigmas() const { return covariance.diagonal().cwiseSqrt(); }
  /// L with L L^T = covariance: a perturbation is L times six independent standard normal numbers.
  Matrix6d root() const { return covariance.llt().matrixL(); }
  double squared_distance(const Rigid3& pose) const {
    const Vector6d difference = camera_difference(camera_from_map, pose);
    return difference.dot(covariance.llt().solve(difference));
  }
};

}  // namespace cpplus
