#pragma once

#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct StampedPose {
  double stamp_s = 0.0;
  Rigid3 map_from_sensor;
};

/// Poses of one sensor, stamps ascending.
using Trajectory = std::vector<StampedPose>;

}  // namespace cpplus
