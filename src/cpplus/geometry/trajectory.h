#pragma once

#include <cstddef>
#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct StampedPose {
  double stamp_s = 0.0;
  Rigid3 map_from_sensor;
};

/// Poses of one sensor, stamps ascending.
using Trajectory = std::vector<StampedPose>;

/// A trajectory made of poses in any order, and what was wrong with the order.
struct OrderedTrajectory {
  Trajectory trajectory;
  size_t num_out_of_order = 0;  // poses that stood behind one with a later stamp; they are put in their place
  double first_out_of_order_s = 0.0;
  size_t num_double = 0;  // poses left out because another has their stamp
  double first_double_s = 0.0;
};

/// Sorts by stamp. Of poses closer together than a twentieth of the median spacing only the first one of the file is
/// kept: their difference is the noise of two estimates, which a curve through both would take for motion.
OrderedTrajectory order_by_stamp(std::vector<StampedPose> poses);

}  // namespace cpplus
