#include "cpplus/refine/surface_match_residual.h"

#include <cmath>

namespace cpplus {

std::optional<SurfaceMatchResidual> surface_match_residual(const SurfaceMatch& match, const Camera& camera_a,
                                                           const ImagePose& pose_a, const Camera& camera_b,
                                                           const ImagePose& pose_b, double range_scale) {
  const Rigid3 a_from_map = pose_a.at(row_fraction(match.pixel_a.y(), camera_a.height()));
  const Rigid3 b_from_map = pose_b.at(row_fraction(match.pixel_b.y(), camera_b.height()));
  const auto bearing = camera_a.unproject(match.pixel_a);
  if (!bearing) return std::nullopt;
  const Eigen::Matrix3d map_from_a = a_from_map.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d center = camera_center(a_from_map);
  const Eigen::Vector3d direction = map_from_a * *bearing;
  const double slope = match.normal_in_map.dot(direction);
  if (std::abs(slope) < 1e-6) return std::nullopt;
  const double range = match.normal_in_map.dot(match.point_in_map - center) / slope;
  if (!(range > 0)) return std::nullopt;

  const double scale = 1.0 + range_scale;
  const Eigen::Vector3d x_in_b = b_from_map * (center + scale * range * direction);
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> d_pixel_d_x;
  if (!camera_b.project(x_in_b, &pixel, &d_pixel_d_x)) return std::nullopt;
  SurfaceMatchResidual r;
  r.residual = pixel - match.pixel_b;
  r.by_range = d_pixel_d_x * (b_from_map.rotation * direction);
  r.by_range_scale = range * r.by_range;
  const Eigen::Matrix<double, 2, 3> d_pixel_d_map = d_pixel_d_x * b_from_map.rotation.toRotationMatrix();
  const Eigen::Matrix3d along_ray = direction * match.normal_in_map.transpose() / slope;
  const Eigen::Matrix3d when_turned = scale * (Eigen::Matrix3d::Identity() - along_ray);
  const Eigen::Matrix3d when_moved = Eigen::Matrix3d::Identity() - scale * along_ray;
  // The camera takes the spot along, contrary to how a perturbation moves a point that stays in the map.
  const Eigen::Matrix<double, 3, 6> taken_along = -d_camera_point_d_delta(range * *bearing);
  r.by_a.leftCols<3>() = d_pixel_d_map * when_turned * map_from_a * taken_along.leftCols<3>();
  r.by_a.rightCols<3>() = d_pixel_d_map * when_moved * map_from_a * taken_along.rightCols<3>();
  r.by_b = d_pixel_d_x * d_camera_point_d_delta(x_in_b);
  return r;
}

}  // namespace cpplus
