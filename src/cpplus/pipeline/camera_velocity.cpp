#include "cpplus/pipeline/camera_velocity.h"

namespace cpplus {

std::optional<Vector6d> camera_velocity(const TrajectorySpline& trajectory, double stamp_s,
                                        const Rigid3& camera_from_map) {
  constexpr double kStep = 1e-3;  // seconds
  const std::optional<Rigid3> map_from_sensor = trajectory.map_from_sensor(stamp_s);
  if (!map_from_sensor) return {};
  // Backwards where the trajectory ends.
  for (const double step : {kStep, -kStep}) {
    const std::optional<Rigid3> later_map_from_sensor = trajectory.map_from_sensor(stamp_s + step);
    if (!later_map_from_sensor) continue;
    const Rigid3 moved = camera_from_map * *map_from_sensor * inverse(*later_map_from_sensor);
    return Vector6d(camera_difference(camera_from_map, moved) / step);
  }
  return {};
}

}  // namespace cpplus
