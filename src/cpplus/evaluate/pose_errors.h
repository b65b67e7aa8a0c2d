#pragma once

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// How far an estimated camera pose is from the reference.
struct PoseError {
  double rotation_deg = 0.0;   // angle of the relative rotation, [0, 180]
  double translation_m = 0.0;  // distance of the two camera centres (not of the stored translations)
};

PoseError pose_error(const Rigid3& estimate_camera_from_map, const Rigid3& reference_camera_from_map);

}  // namespace cpplus
