#include "cpplus/refine/projected_sample.h"

namespace cpplus {

namespace {

// Rows hardly move while one is read: each step leaves a few percent of the last one's change.
constexpr int kRowSteps = 3;

std::optional<Rigid3> pose_of_row(const Camera& camera, const ImagePose& pose, const Eigen::Vector3d& x_in_map) {
  Rigid3 camera_from_map = pose.camera_from_map;
  for (int step = 0; pose.moves() && step < kRowSteps; ++step) {
    const auto pixel = camera.project(camera_from_map * x_in_map);
    if (!pixel) return std::nullopt;
    camera_from_map = pose.at(row_fraction(pixel->y(), camera.height()));
  }
  return camera_from_map;
}

}  // namespace

std::optional<ProjectedSample> SampleProjector::project(const EdgeSample& sample) const {
  if (!pose_.moves()) return project(sample, pose_.camera_from_map, rotation_);
  const auto row_from_map = pose_of_row(camera_, pose_, sample.x_in_map);
  if (!row_from_map) return std::nullopt;
  return project(sample, *row_from_map, row_from_map->rotation.toRotationMatrix());
}

std::optional<ProjectedSample> SampleProjector::project(const EdgeSample& sample, const Rigid3& camera_from_map,
                                                        const Eigen::Matrix3d& rotation) const {
  ProjectedSample projected;
  projected.camera_from_map = camera_from_map;
  const Eigen::Vector3d x_in_camera = rotation * sample.x_in_map + camera_from_map.translation;
  Eigen::Matrix<double, 2, 3> d_pixel_d_camera_point;
  if (!camera_.project(x_in_camera, &projected.pixel, &d_pixel_d_camera_point)) return std::nullopt;

  projected.d_pixel_d_point = d_pixel_d_camera_point * rotation;
  const Eigen::Vector2d tangent = projected.d_pixel_d_point * sample.direction_in_map;
  const double length = tangent.norm();
  if (length < 1e-6) return std::nullopt;
  projected.normal = Eigen::Vector2d(-tangent.y(), tangent.x()) / length;
  projected.d_pixel_d_delta = d_pixel_d_camera_point * d_camera_point_d_delta(x_in_camera);
  return projected;
}

}  // namespace cpplus
