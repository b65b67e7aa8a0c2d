#include "cpplus/pipeline/camera_velocity.h"

#include <algorithm>

namespace cpplus {
namespace {

Rigid3 interpolate(const StampedPose& a, const StampedPose& b, double stamp_s) {
  const double share = (stamp_s - a.stamp_s) / (b.stamp_s - a.stamp_s);
  return {a.map_from_sensor.rotation.slerp(share, b.map_from_sensor.rotation),
          (1.0 - share) * a.map_from_sensor.translation + share * b.map_from_sensor.translation};
}

}  // namespace

std::optional<Vector6d> camera_velocity(const Trajectory& trajectory, double stamp_s, const Rigid3& camera_from_map) {
  if (trajectory.size() < 2 || stamp_s < trajectory.front().stamp_s || stamp_s > trajectory.back().stamp_s) return {};
  auto after = std::upper_bound(trajectory.begin(), trajectory.end(), stamp_s,
                                [](double stamp, const StampedPose& pose) { return stamp < pose.stamp_s; });
  if (after == trajectory.end()) --after;
  const StampedPose& a = *(after - 1);
  const StampedPose& b = *after;
  constexpr double kStep = 1e-3;  // seconds
  const Rigid3 camera_from_sensor = camera_from_map * interpolate(a, b, stamp_s);
  const Rigid3 moved = camera_from_sensor * inverse(interpolate(a, b, stamp_s + kStep));
  return Vector6d(camera_difference(camera_from_map, moved) / kStep);
}

}  // namespace cpplus
