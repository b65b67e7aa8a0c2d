#pragma once

#include <optional>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/geometry/trajectory_spline.h"

namespace cpplus {

/// Velocity of a camera that moves rigidly with the trajectory's sensor (map_from_sensor), at an instant: perturbation
/// per second (geometry/rigid3.h; rad/s, m/s, in the camera frame). Nothing outside the trajectory or where it has no
/// motion: a single pose.
std::optional<Vector6d> camera_velocity(const TrajectorySpline& trajectory, double stamp_s,
                                        const Rigid3& camera_from_map);

}  // namespace cpplus
