#include "cpplus/simulate/map_fit.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>

namespace cpplus {
namespace {

/// Of a panorama: the difference the short way round, across the seam; and columns as wide as on the equator, because
/// towards the poles a hair's breadth becomes a jump from column to column.
void unroll(const Camera& camera, const Eigen::Vector3d& x_in_camera, Eigen::Vector2d* difference_px,
            Eigen::Matrix<double, 2, 6>* jacobian) {
  if (camera.model() != CameraModel::kEquirectangular) return;
  const double scale = std::hypot(x_in_camera.x(), x_in_camera.z()) / x_in_camera.norm();
  difference_px->x() = scale * std::remainder(difference_px->x(), static_cast<double>(camera.width()));
  jacobian->row(0) *= scale;
}

}  // namespace

Rigid3 fit_pose_to_map(const Camera& camera, const Rigid3& true_camera_from_map,
                       const std::vector<DisplacedPoint>& points) {
  constexpr int kIterations = 8;
  constexpr int kMinPoints = 30;
  Rigid3 camera_from_map = true_camera_from_map;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Matrix6d information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    int count = 0;
    for (const DisplacedPoint& point : points) {
      const auto target = camera.project(true_camera_from_map * point.x_in_truth);
      const Eigen::Vector3d x = camera_from_map * point.x_in_map;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> d_pixel_d_x;
      if (!target || !camera.project(x, &pixel, &d_pixel_d_x)) continue;
      Eigen::Matrix<double, 2, 6> jacobian = d_pixel_d_x * d_camera_point_d_delta(x);
      Eigen::Vector2d difference_px = pixel - *target;
      unroll(camera, x, &difference_px, &jacobian);
      information += jacobian.transpose() * jacobian;
      gradient += jacobian.transpose() * difference_px;
      ++count;
    }
    if (count < kMinPoints) return true_camera_from_map;
    const Vector6d delta = -information.ldlt().solve(gradient);
    camera_from_map = perturb_camera(camera_from_map, delta);
    if (delta.norm() < 1e-10) break;
  }
  return camera_from_map;
}

}  // namespace cpplus
