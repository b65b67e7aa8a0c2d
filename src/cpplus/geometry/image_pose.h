#pragma once

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Place of a row between the first (-0.5) and the last one (0.5) of an image.
inline double row_fraction(double row_px, int height_px) {
  return height_px > 1 ? row_px / (height_px - 1) - 0.5 : 0.0;
}

/// Pose of an image whose rows are exposed one after the other (rolling shutter): that of its middle row, and the
/// perturbation (geometry/rigid3.h) by which the camera moves from the first row to the last, at constant velocity.
/// Without motion all rows have the same pose (global shutter).
struct ImagePose {
  Rigid3 camera_from_map;
  Vector6d motion = Vector6d::Zero();

  ImagePose(const Rigid3& pose, const Vector6d& motion_over_rows = Vector6d::Zero())  // NOLINT: any pose is one
      : camera_from_map(pose), motion(motion_over_rows) {}

  bool moves() const { return !motion.isZero(); }
  /// The pose while a row is exposed.
  Rigid3 at(double fraction) const {
    return moves() ? perturb_camera(camera_from_map, fraction * motion) : camera_from_map;
  }
};

}  // namespace cpplus
