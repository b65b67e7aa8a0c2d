#include "cpplus/evaluate/pose_errors.h"

#include <cmath>

namespace cpplus {

PoseError pose_error(const Rigid3& estimate_camera_from_map, const Rigid3& reference_camera_from_map) {
  const Vector6d difference = camera_difference(reference_camera_from_map, estimate_camera_from_map);
  return {difference.head<3>().norm() * 180.0 / M_PI, difference.tail<3>().norm()};
}

}  // namespace cpplus
