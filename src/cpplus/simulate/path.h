#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/simulate/scene.h"

namespace cpplus {

/// The smooth motion of the LiDAR along a way: a uniform cubic B-spline of position and heading with time as its
/// parameter (the mean speed is the way's; evenly spaced points give an even speed), plus the bob and sway of steps.
/// Twice differentiable at any time in [0, duration_s].
class Path {
 public:
  explicit Path(const Way& way);

  double duration_s() const { return duration_s_; }
  Rigid3 map_from_lidar(double time_s) const;

 private:
  Eigen::Vector3d curve(double parameter) const;  // x, y, yaw

  Way way_;
  std::vector<Eigen::Vector3d> control_;  // x, y, unwrapped yaw
  double duration_s_ = 0.0;
};

}  // namespace cpplus
