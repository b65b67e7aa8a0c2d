#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/geometry/trajectory.h"

namespace cpplus {

/// Where an instant lies with respect to a trajectory.
enum class Coverage { kCovered, kBefore, kAfter, kInGap };

/// A smooth curve through the poses of a trajectory, for the pose at any instant inside it.
///
/// Translation and unit quaternion (as a 4-vector, signs aligned) are interpolated by cubic splines with continuous
/// second derivatives over the stamps as they are, evenly spaced or not, and ends by end_rate_weights(); the quaternion
/// is then normalised. That is as accurate as a cumulative cubic B-spline on SO(3), fourth order in the spacing of the
/// stamps, but interpolates without an iterative solution. It does not depend on the choice of frames: multiplying a
/// quaternion by a constant one from either side is an orthogonal map of R^4, which a spline and the normalisation
/// commute with.
///
/// Two poses farther apart than max_gap_s end one curve and begin another; there is no pose between them, nor before
/// the first stamp or after the last: nothing is extrapolated.
class TrajectorySpline {
 public:
  TrajectorySpline() = default;
  /// Stamps must ascend strictly (assert); consecutive rotations are taken for the ones less than 180 degrees apart.
  explicit TrajectorySpline(const Trajectory& trajectory, double max_gap_s = std::numeric_limits<double>::infinity());

  Coverage coverage(double stamp_s) const;

  /// map_from_sensor at the instant; nothing where coverage() is not kCovered.
  std::optional<Rigid3> map_from_sensor(double stamp_s) const;

 private:
  using Knot = Eigen::Matrix<double, 7, 1>;  // translation, then quaternion x y z w

  void solve_rates(size_t begin, size_t end);
  /// Derivative at the first of `count` knots, which follow each other in the direction 1 or -1.
  Knot end_rate(size_t first, size_t count, int direction) const;

  std::vector<double> stamps_s_;
  std::vector<Knot> knots_;
  std::vector<Knot> rates_;  // derivatives at the knots, per second
  double max_gap_s_ = 0.0;
};

}  // namespace cpplus
