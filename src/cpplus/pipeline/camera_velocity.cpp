#include "cpplus/pipeline/camera_velocity.h"

namespace cpplus {

std::optional<Vector6d> camera_velocity(const TrajectorySpline& trajectory, double stamp_s,
                                        const Rigid3& camera_from_map) {
  const std::optional<Rigid3> map_from_sensor = trajectory.map_from_sensor(stamp_s);
  const std::optional<Vector6d> sensor_velocity = trajectory.velocity(stamp_s);
  if (!map_from_sensor || !sensor_velocity) return {};
  // The same motion seen from the camera: turned into its axes, plus what the turning moves the camera about the
  // sensor.
  const Rigid3 camera_from_sensor = camera_from_map * *map_from_sensor;
  const Eigen::Vector3d turning = camera_from_sensor.rotation * sensor_velocity->head<3>();
  Vector6d velocity;
  velocity << turning,
      camera_from_sensor.rotation * sensor_velocity->tail<3>() + camera_from_sensor.translation.cross(turning);
  return velocity;
}

}  // namespace cpplus
