#include "cpplus/cloud/select_roots.h"

#include <algorithm>
#include <cmath>

namespace cpplus {

std::vector<uint32_t> select_roots(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                   double max_distance_m, double widening_rad) {
  const Eigen::Vector3d axis_in_map = camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double half_angle = std::min(camera.max_view_angle() + widening_rad, M_PI);
  return map.roots_in_frustum(camera_center(camera_from_map), axis_in_map, half_angle, max_distance_m);
}

}  // namespace cpplus
