#pragma once

#include <Eigen/Core>

#include "cpplus/geometry/camera.h"

namespace cpplus {

/// Bounds of X / Z and Y / Z of what an image may see: a quick test ahead of the projection. Cameras that see far off
/// their axis (fisheyes, panoramas) have no bounds, and nothing is excluded.
class ViewBox {
 public:
  explicit ViewBox(const Camera& camera);

  bool excludes(const Eigen::Vector3f& x_in_camera) const {
    const Eigen::Vector3f& x = x_in_camera;
    return limited_ && (x.x() < low_.x() * x.z() || x.x() > high_.x() * x.z() || x.y() < low_.y() * x.z() ||
                        x.y() > high_.y() * x.z() || x.z() < 0.0f);
  }

  /// Whether all points within radius_m of this one are outside.
  bool excludes(const Eigen::Vector3f& x_in_camera, float radius_m) const {
    if (!limited_) return false;
    const Eigen::Vector3f& x = x_in_camera;
    const Eigen::Array2f below = low_ * x.z() - x.head<2>().array() - radius_m * (1.0f + low_.abs());
    const Eigen::Array2f above = x.head<2>().array() - high_ * x.z() - radius_m * (1.0f + high_.abs());
    return x.z() < -radius_m || (below > 0.0f).any() || (above > 0.0f).any();
  }

 private:
  Eigen::Array2f low_ = Eigen::Array2f::Zero();
  Eigen::Array2f high_ = Eigen::Array2f::Zero();
  bool limited_ = false;
};

}  // namespace cpplus
