#pragma once

#include <Eigen/Core>
#include <optional>

#include "cpplus/cloud/surface_match.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/image_pose.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Where the spot that image a shows is expected in image b, minus where it was found, pixels.
struct SurfaceMatchResidual {
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();
  /// By the perturbations (geometry/rigid3.h) of either camera.
  Eigen::Matrix<double, 2, 6> by_a = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Matrix<double, 2, 6> by_b = Eigen::Matrix<double, 2, 6>::Zero();
  /// By the range of the surface along the ray of camera a, pixels per metre: along the epipolar line.
  Eigen::Vector2d by_range = Eigen::Vector2d::Zero();
  /// By range_scale, pixels.
  Eigen::Vector2d by_range_scale = Eigen::Vector2d::Zero();
};

/// The ray of pixel_a is met with the plane (n, p), and that point projected into image b:
///
///   x = c_a + (1 + k) s d,  d = R_map_a bearing,  s = n^T (p - c_a) / (n^T d),     r = pi_b(T_b_map x) - pixel_b
///
/// with the range scale k: by which share of its range the surface is farther than the map has it. A camera a that
/// moves by v moves the point by (I - (1 + k) d n^T / (n^T d)) v, for k = 0 always within the plane. Under a rolling
/// shutter both poses are those of the rows of the two pixels. Nothing where a camera model does not hold, or the plane
/// is not met in front of camera a.
std::optional<SurfaceMatchResidual> surface_match_residual(const SurfaceMatch& match, const Camera& camera_a,
                                                           const ImagePose& pose_a, const Camera& camera_b,
                                                           const ImagePose& pose_b, double range_scale = 0.0);

}  // namespace cpplus
