#pragma once

#include <Eigen/Core>

namespace cpplus {

/// A point of the map that an image shows.
struct IntensityPoint {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  Eigen::Vector3d x_in_map = Eigen::Vector3d::Zero();
  float intensity = 0.0f;  // of the LiDAR, in any unit that is alike in the whole map
};

/// Where an image shows a spot of the map, by the pattern of LiDAR intensities around it.
struct IntensityMatch {
  Eigen::Vector3d x_in_map = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  /// Of the pixel, 1/px^2; next to nothing along a stripe.
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  /// Below one where the same points are in several matches.
  double weight = 1.0;
  double correlation = 0.0;  // of intensity and brightness, either sign, [0, 1]
};

}  // namespace cpplus
