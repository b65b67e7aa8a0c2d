#include "cpplus/simulate/path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr double kTurnMetresPerRad = 0.6;  // turning on the spot takes time too
constexpr double kStepHz = 1.8;

}  // namespace

Path::Path(const Way& way) : way_(way) {
  double yaw = way.points.front().yaw_rad;
  for (const WayPoint& point : way.points) {
    yaw += std::remainder(point.yaw_rad - yaw, 2.0 * M_PI);
    control_.emplace_back(point.position.x(), point.position.y(), yaw);
  }
  // Doubled ends make the spline begin and end close to the first and last control point.
  control_.insert(control_.begin(), control_.front());
  control_.push_back(control_.back());
  double length = 0.0;
  for (size_t i = 1; i < control_.size(); ++i) {
    const Vector3d step = control_[i] - control_[i - 1];
    length += std::hypot(step.head<2>().norm(), kTurnMetresPerRad * step.z());
  }
  duration_s_ = std::max(1e-3, length / way.speed_mps);  // a way that goes nowhere lasts, too
}

Vector3d Path::curve(double parameter) const {
  const int spans = static_cast<int>(control_.size()) - 3;
  const int span = std::clamp(static_cast<int>(std::floor(parameter)), 0, spans - 1);
  const double t = parameter - span;
  const auto at = [&](int i) -> const Vector3d& { return control_[static_cast<size_t>(span + i)]; };
  return ((1 - t) * (1 - t) * (1 - t) * at(0) + (3 * t * t * t - 6 * t * t + 4) * at(1) +
          (-3 * t * t * t + 3 * t * t + 3 * t + 1) * at(2) + t * t * t * at(3)) /
         6.0;
}

Rigid3 Path::map_from_lidar(double time_s) const {
  const double spans = static_cast<double>(control_.size()) - 3.0;
  const Vector3d xy_yaw = curve(spans * std::clamp(time_s / duration_s_, 0.0, 1.0));
  const double phase = 2.0 * M_PI * kStepHz * time_s;
  const double pitch = way_.sway_rad * (0.7 * std::sin(phase + 0.6) + 0.5 * std::sin(0.31 * phase));
  const double roll = way_.sway_rad * (0.6 * std::sin(0.5 * phase + 1.1) + 0.6 * std::sin(0.23 * phase + 2.0));
  const double yaw = xy_yaw.z() + 0.7 * way_.sway_rad * std::sin(0.5 * phase);
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(pitch, Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(roll, Vector3d::UnitX());
  return Rigid3(rotation, Vector3d(xy_yaw.x(), xy_yaw.y(), way_.lidar_height_m + way_.bob_m * std::sin(phase)));
}

}  // namespace cpplus
