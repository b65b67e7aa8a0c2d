#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cpplus {

/// The same spot of the map's surface seen in two images.
struct SurfaceMatch {
  uint32_t image_a = 0;
  uint32_t image_b = 0;
  Eigen::Vector2d pixel_a = Eigen::Vector2d::Zero();
  Eigen::Vector2d pixel_b = Eigen::Vector2d::Zero();
  int32_t plane = -1;  // index of the plane instance; -1 where the surface is no plane of the map
  /// The surface around the spot: a point of it (map frame, metres) and its unit normal.
  Eigen::Vector3d point_in_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_in_map = Eigen::Vector3d::UnitZ();
  double range_sigma_m = 0.0;  // of the surface along the ray of image a
  double correlation = 0.0;  // of the two patches, (0, 1]
};

}  // namespace cpplus
