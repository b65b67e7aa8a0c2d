#include "cpplus/refine/projected_sample.h"

namespace cpplus {

std::optional<ProjectedSample> project_sample(const Camera& camera, const Rigid3& camera_from_map,
                                              const EdgeSample& sample) {
  const Eigen::Vector3d x_in_camera = camera_from_map * sample.x_in_map;
  ProjectedSample projected;
  Eigen::Matrix<double, 2, 3> d_pixel_d_camera_point;
  if (!camera.project(x_in_camera, &projected.pixel, &d_pixel_d_camera_point)) return std::nullopt;

  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  projected.d_pixel_d_point = d_pixel_d_camera_point * rotation;
  const Eigen::Vector2d tangent = projected.d_pixel_d_point * sample.direction_in_map;
  const double length = tangent.norm();
  if (length < 1e-6) return std::nullopt;
  projected.normal = Eigen::Vector2d(-tangent.y(), tangent.x()) / length;

  // x_in_camera(delta) = Exp(-delta_rotation) (x_in_camera - delta_translation): see perturb_camera.
  Eigen::Matrix<double, 3, 6> d_point_d_delta;
  d_point_d_delta << 0, -x_in_camera.z(), x_in_camera.y(), -1, 0, 0,  //
      x_in_camera.z(), 0, -x_in_camera.x(), 0, -1, 0,                 //
      -x_in_camera.y(), x_in_camera.x(), 0, 0, 0, -1;
  projected.d_pixel_d_delta = d_pixel_d_camera_point * d_point_d_delta;
  return projected;
}

}  // namespace cpplus
