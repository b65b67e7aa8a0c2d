#include "cpplus/geometry/trajectory_spline.h"

#include <algorithm>
#include <cassert>

#include "cpplus/geometry/end_rate.h"

namespace cpplus {
namespace {

constexpr size_t kEndKnots = 8;  // at each end of a curve they give its derivative there

}  // namespace

TrajectorySpline::TrajectorySpline(const Trajectory& trajectory, double max_gap_s) : max_gap_s_(max_gap_s) {
  for (const StampedPose& pose : trajectory) {
    assert(stamps_s_.empty() || pose.stamp_s > stamps_s_.back());
    Knot knot;
    knot << pose.map_from_sensor.translation, pose.map_from_sensor.rotation.coeffs();
    // q and -q are the same rotation; take the one nearer to the knot before.
    if (!knots_.empty() && knots_.back().tail<4>().dot(knot.tail<4>()) < 0.0) knot.tail<4>() *= -1.0;
    stamps_s_.push_back(pose.stamp_s);
    knots_.push_back(knot);
  }
  rates_.assign(knots_.size(), Knot::Zero());
  size_t begin = 0;
  for (size_t i = 1; i <= knots_.size(); ++i) {
    if (i < knots_.size() && stamps_s_[i] - stamps_s_[i - 1] <= max_gap_s_) continue;
    solve_rates(begin, i);
    begin = i;
  }
}

// Derivatives of the cubic spline through the knots [begin, end): the second derivative is continuous at inner knots,
// the first at the ends is estimated from the knots nearby. Three knots make a parabola, two a line; one has none.
void TrajectorySpline::solve_rates(size_t begin, size_t end) {
  const size_t n = end - begin;
  if (n < 2) return;
  const auto step = [&](size_t i) { return stamps_s_[begin + i + 1] - stamps_s_[begin + i]; };
  const auto slope = [&](size_t i) -> Knot { return (knots_[begin + i + 1] - knots_[begin + i]) / step(i); };
  if (n == 2) {
    rates_[begin] = rates_[begin + 1] = slope(0);
    return;
  }
  if (n == 3) {
    const Knot curvature = (slope(1) - slope(0)) / (step(0) + step(1));  // half the second derivative
    rates_[begin] = slope(0) - step(0) * curvature;
    rates_[begin + 1] = slope(0) + step(0) * curvature;
    rates_[begin + 2] = slope(1) + step(1) * curvature;
    return;
  }
  // Tridiagonal system lower * d[i-1] + diagonal * d[i] + upper * d[i+1] = right; de Boor, A Practical Guide to
  // Splines, ch. IV.
  std::vector<double> lower(n);
  std::vector<double> diagonal(n);
  std::vector<double> upper(n);
  std::vector<Knot> right(n);
  diagonal[0] = diagonal[n - 1] = 1.0;
  right[0] = end_rate(begin, std::min(n, kEndKnots), 1);
  right[n - 1] = end_rate(end - 1, std::min(n, kEndKnots), -1);
  for (size_t i = 1; i + 1 < n; ++i) {
    lower[i] = step(i);
    diagonal[i] = 2.0 * (step(i - 1) + step(i));
    upper[i] = step(i - 1);
    right[i] = 3.0 * (step(i) * slope(i - 1) + step(i - 1) * slope(i));
  }
  for (size_t i = 1; i < n; ++i) {
    const double factor = lower[i] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    right[i] -= factor * right[i - 1];
  }
  rates_[begin + n - 1] = right[n - 1] / diagonal[n - 1];
  for (size_t i = n - 1; i-- > 0;) {
    rates_[begin + i] = (right[i] - upper[i] * rates_[begin + i + 1]) / diagonal[i];
  }
}

TrajectorySpline::Knot TrajectorySpline::end_rate(size_t first, size_t count, int direction) const {
  const auto knot_of = [&](size_t k) { return direction > 0 ? first + k : first - k; };
  Eigen::VectorXd stamps_s(count);
  for (size_t k = 0; k < count; ++k) stamps_s[static_cast<Eigen::Index>(k)] = stamps_s_[knot_of(k)];
  const Eigen::VectorXd weights = end_rate_weights(stamps_s);
  Knot rate = Knot::Zero();
  for (size_t k = 0; k < count; ++k)
    rate += weights[static_cast<Eigen::Index>(k)] * (knots_[knot_of(k)] - knots_[first]);
  return rate;
}

Coverage TrajectorySpline::coverage(double stamp_s) const {
  if (stamps_s_.empty() || stamp_s < stamps_s_.front()) return Coverage::kBefore;
  if (stamp_s > stamps_s_.back()) return Coverage::kAfter;
  const auto after = std::lower_bound(stamps_s_.begin(), stamps_s_.end(), stamp_s);
  if (*after == stamp_s) return Coverage::kCovered;
  return *after - *(after - 1) > max_gap_s_ ? Coverage::kInGap : Coverage::kCovered;
}

std::optional<Rigid3> TrajectorySpline::map_from_sensor(double stamp_s) const {
  if (coverage(stamp_s) != Coverage::kCovered) return {};
  const auto after = std::lower_bound(stamps_s_.begin(), stamps_s_.end(), stamp_s);
  const size_t i = static_cast<size_t>(after - stamps_s_.begin());
  Knot value = knots_[i];
  if (stamps_s_[i] != stamp_s) {
    // Cubic Hermite polynomial between the knots i - 1 and i.
    const double step = stamps_s_[i] - stamps_s_[i - 1];
    const double u = (stamp_s - stamps_s_[i - 1]) / step;
    const Knot rise = knots_[i] - knots_[i - 1];
    const Knot bend = (1.0 - u) * (step * rates_[i - 1] - rise) + u * (rise - step * rates_[i]);
    value = knots_[i - 1] + u * rise + u * (1.0 - u) * bend;
  }
  return Rigid3(Eigen::Quaterniond(Eigen::Vector4d(value.tail<4>())), value.head<3>());
}

}  // namespace cpplus
