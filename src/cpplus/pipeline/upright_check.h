#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// How the images of a camera stand, and whether a usual mistake in its extrinsic would explain it.
struct UprightCheck {
  /// Median angle between the image's downward axis and the map's, deg.
  double tilt_deg = 0.0;
  /// The mistake whose correction makes the images stand upright, in words, where they do not; and their angle then.
  std::optional<std::string> mistake;
  double corrected_tilt_deg = 0.0;
};

/// Most cameras are mounted upright and most maps have a vertical axis. So when the images stand more than 60 degrees
/// from upright with the extrinsic as given, and less than 30 with its inverse or with the numbers of its quaternion
/// read in the other order (w first or last), that mistake is a likely explanation. It remains a guess: a camera that
/// is mounted on its side or looks down does not stand either, and mistakes that leave the images about upright (the
/// inverse of two frames with nearly the same axes, a wrong translation) are not seen.
UprightCheck check_upright(const Rigid3& camera_from_sensor, const std::vector<Rigid3>& map_from_sensor,
                           const Eigen::Vector3d& up_in_map);

}  // namespace cpplus
