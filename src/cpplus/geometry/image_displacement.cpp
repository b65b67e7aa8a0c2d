#include "cpplus/geometry/image_displacement.h"

namespace cpplus {

double mean_displacement_px(const Camera& camera, const std::vector<Eigen::Vector3d>& points_in_map,
                            const Rigid3& from_camera_from_map, const Rigid3& to_camera_from_map) {
  double sum = 0.0;
  int count = 0;
  for (const Eigen::Vector3d& x : points_in_map) {
    const auto from = camera.project(from_camera_from_map * x);
    const auto to = camera.project(to_camera_from_map * x);
    if (!from || !to) continue;
    sum += (*to - *from).norm();
    ++count;
  }
  return count == 0 ? 0.0 : sum / count;
}

}  // namespace cpplus
