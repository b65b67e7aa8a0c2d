#pragma once

#include <Eigen/Core>

#include "cpplus/geometry/camera.h"

namespace cpplus {

/// Bounds of X / Z and Y / Z of what an image may show: a quick test that spares most points outside their projection.
struct TangentBox {
  Eigen::Array2f low = Eigen::Array2f::Zero();
  Eigen::Array2f high = Eigen::Array2f::Zero();
  bool limited = false;  // false: excludes nothing

  /// Whether the image surely does not show a point (camera frame).
  bool excludes(const Eigen::Vector3f& x_in_camera) const {
    const Eigen::Vector3f& x = x_in_camera;
    return limited && (x.x() < low.x() * x.z() || x.x() > high.x() * x.z() || x.y() < low.y() * x.z() ||
                       x.y() > high.y() * x.z() || x.z() < 0.0f);
  }

  /// Whether it surely shows no point within radius_m of this one.
  bool excludes(const Eigen::Vector3f& x_in_camera, float radius_m) const {
    if (!limited) return false;
    const Eigen::Vector3f& x = x_in_camera;
    const Eigen::Array2f below = low * x.z() - x.head<2>().array() - radius_m * (1.0f + low.abs());
    const Eigen::Array2f above = x.head<2>().array() - high * x.z() - radius_m * (1.0f + high.abs());
    return x.z() < -radius_m || (below > 0.0f).any() || (above > 0.0f).any();
  }
};

/// The box around the border of the image, with 1 % to spare. Not limited for cameras that see farther than 78 degrees
/// off their axis.
TangentBox tangent_box(const Camera& camera);

}  // namespace cpplus
