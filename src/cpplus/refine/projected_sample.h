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

/// Projects edge samples into one image (Eq. 3 of Cui & Schwertfeger 2022) with their derivatives. Under a rolling
/// shutter the row in which a point is seen and the pose of that row depend on each other; a few steps of a fixed point
/// find both.
class SampleProjector {
 public:
  /// The camera must outlive this.
  SampleProjector(const Camera& camera, const ImagePose& pose)
      : camera_(camera), pose_(pose), rotation_(pose.camera_from_map.rotation.toRotationMatrix()) {}

  /// Nothing where the camera model does not hold or the edge is seen end-on.
  std::optional<ProjectedSample> project(const EdgeSample& sample) const;

 private:
  std::optional<ProjectedSample> project(const EdgeSample& sample, const Rigid3& camera_from_map,
                                         const Eigen::Matrix3d& rotation) const;

  const Camera& camera_;
  ImagePose pose_;
  Eigen::Matrix3d rotation_;  // of the middle row
};

inline std::optional<ProjectedSample> project_sample(const Camera& camera, const ImagePose& pose,
                                                     const EdgeSample& sample) {
  return SampleProjector(camera, pose).project(sample);
}

}  // namespace cpplus
