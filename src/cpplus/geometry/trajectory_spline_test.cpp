#include "cpplus/geometry/trajectory_spline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// A walk of 1.5 m/s round corners of 90 degrees in 2 s, with the bob and sway of 1.8 steps a second.
Rigid3 walk(double t) {
  const double phase = 2.0 * M_PI * 1.8 * t;
  const double heading = 1.2 * std::sin(0.65 * t);
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(heading + 0.02 * std::sin(0.5 * phase), Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(0.3 + 0.015 * std::sin(phase + 0.6), Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(0.02 * std::sin(0.5 * phase + 1.1), Vector3d::UnitX());
  return {rotation, Vector3d(1.5 * t, 2.0 * std::sin(0.65 * t), 1.4 + 0.025 * std::sin(phase))};
}

Trajectory sample(const std::function<Rigid3(double)>& way, double end_s, double step_s, double jitter = 0.0) {
  Trajectory trajectory;
  for (int i = 0; i * step_s <= end_s + 1e-9; ++i) {
    const double stamp = step_s * (i + jitter * std::sin(7.0 * i));
    trajectory.push_back({stamp, way(stamp)});
  }
  return trajectory;
}

struct Worst {
  double position_m = 0.0;
  double angle_deg = 0.0;
};

Worst worst_error(const TrajectorySpline& spline, const std::function<Rigid3(double)>& way, double begin, double end) {
  Worst worst;
  for (double t = begin; t <= end; t += 0.0037) {
    const Rigid3 pose = spline.map_from_sensor(t).value();
    worst.position_m = std::max(worst.position_m, (pose.translation - way(t).translation).norm());
    worst.angle_deg = std::max(worst.angle_deg, rotation_angle_between(pose, way(t)) * 180.0 / M_PI);
  }
  return worst;
}

TEST(TrajectorySpline, HalfWayOfAConstantMotionIsTheMeanOfItsEnds) {
  Trajectory trajectory(2);
  trajectory[1].stamp_s = 2.0;
  trajectory[1].map_from_sensor =
      Rigid3(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 3, Vector3d::UnitZ())), Vector3d(4, 0, -2));
  const Rigid3 half = TrajectorySpline(trajectory).map_from_sensor(1.0).value();
  EXPECT_TRUE(half.translation.isApprox(Vector3d(2, 0, -1), 1e-15));
  EXPECT_NEAR(so3_log(half.rotation).z(), M_PI / 6, 1e-12);
}

TEST(TrajectorySpline, CubicMotionIsReproducedExactly) {
  const auto cubic = [](double t) { return Rigid3(Eigen::Quaterniond::Identity(), Vector3d(t * t * t - t, t * t, 1)); };
  for (const double jitter : {0.0, 0.3}) {
    const Trajectory trajectory = sample(cubic, 1.2, 0.2, jitter);
    const TrajectorySpline spline(trajectory);
    const double end = trajectory.back().stamp_s;
    EXPECT_LT(worst_error(spline, cubic, trajectory.front().stamp_s, end).position_m, 1e-12);
  }
  const TrajectorySpline parabola(
      sample([](double t) { return Rigid3(Eigen::Quaterniond::Identity(), Vector3d(t * t, 0, 0)); }, 2, 1));
  EXPECT_NEAR(parabola.map_from_sensor(0.5).value().translation.x(), 0.25, 1e-15);
}

TEST(TrajectorySpline, PassesThroughItsKnots) {
  const Trajectory trajectory = sample(walk, 3.0, 0.1, 0.2);
  const TrajectorySpline spline(trajectory);
  for (const StampedPose& pose : trajectory) {
    const Rigid3 back = spline.map_from_sensor(pose.stamp_s).value();
    EXPECT_EQ(back.translation, pose.map_from_sensor.translation);
    EXPECT_LT(rotation_angle_between(back, pose.map_from_sensor), 1e-14);
  }
}

TEST(TrajectorySpline, WalkingAtTenHertzIsWithinTwoMillimetresInAllIntervals) {
  for (const double jitter : {0.0, 0.15}) {
    Worst inside, ends;
    // The phase of the step at either end changes with the length.
    for (double length = 2.0; length < 12.0; length += 0.1) {
      const Trajectory trajectory = sample(walk, length, 0.1, jitter);
      const TrajectorySpline spline(trajectory);
      const size_t n = trajectory.size();
      const auto stamp = [&](size_t i) { return trajectory[i].stamp_s; };
      for (const auto& [begin, end, worst] : {std::tuple(stamp(0), stamp(1), &ends),
                                              {stamp(n - 2), stamp(n - 1), &ends},
                                              {stamp(1), stamp(n - 2), &inside}}) {
        const Worst here = worst_error(spline, walk, begin, end);
        worst->position_m = std::max(worst->position_m, here.position_m);
        worst->angle_deg = std::max(worst->angle_deg, here.angle_deg);
      }
    }
    for (const Worst& worst : {inside, ends}) {
      EXPECT_LT(worst.position_m, 0.002) << jitter;
      EXPECT_LT(worst.angle_deg, 0.02) << jitter;
    }
    const std::string name = jitter == 0.0 ? "even" : "uneven";
    RecordProperty(name + "_inside_mm", std::to_string(1e3 * inside.position_m));
    RecordProperty(name + "_inside_deg", std::to_string(inside.angle_deg));
    RecordProperty(name + "_ends_mm", std::to_string(1e3 * ends.position_m));
    RecordProperty(name + "_ends_deg", std::to_string(ends.angle_deg));
  }
}

TEST(TrajectorySpline, ErrorFallsWithTheFourthPowerOfTheSpacing) {
  const double coarse = worst_error(TrajectorySpline(sample(walk, 10.0, 0.1)), walk, 1.0, 9.0).position_m;
  const double fine = worst_error(TrajectorySpline(sample(walk, 10.0, 0.05)), walk, 1.0, 9.0).position_m;
  EXPECT_LT(fine, coarse / 12.0);
}

TEST(TrajectorySpline, DoesNotDependOnTheFrames) {
  const Rigid3 other_from_map(Eigen::Quaterniond(0.2, 0.4, -0.8, 0.4), Vector3d(30, -20, 5));
  const Eigen::Quaterniond sensor_from_other(0.5, 0.5, -0.5, 0.5);
  const Trajectory trajectory = sample(walk, 4.0, 0.1);
  Trajectory moved = trajectory;
  for (StampedPose& pose : moved)
    pose.map_from_sensor = other_from_map * pose.map_from_sensor * Rigid3(sensor_from_other, Vector3d::Zero());
  const TrajectorySpline spline(trajectory);
  const TrajectorySpline moved_spline(moved);
  for (double t = 0.03; t < 4.0; t += 0.1) {
    const Rigid3 expected = other_from_map * *spline.map_from_sensor(t) * Rigid3(sensor_from_other, Vector3d::Zero());
    const Rigid3 actual = moved_spline.map_from_sensor(t).value();
    EXPECT_LT((actual.translation - expected.translation).norm(), 1e-12);
    EXPECT_LT(rotation_angle_between(actual, expected), 1e-12);
  }
}

TEST(TrajectorySpline, QuaternionsOfEitherSignAreTheSameMotion) {
  Trajectory trajectory = sample(walk, 2.0, 0.1);
  const TrajectorySpline spline(trajectory);
  for (size_t i = 0; i < trajectory.size(); i += 3) trajectory[i].map_from_sensor.rotation.coeffs() *= -1.0;
  EXPECT_LT(rotation_angle_between(*TrajectorySpline(trajectory).map_from_sensor(0.95), *spline.map_from_sensor(0.95)),
            1e-14);
}

TEST(TrajectorySpline, GapsAndEndsAreNotBridged) {
  Trajectory trajectory = sample(walk, 1.0, 0.1);
  trajectory.push_back({3.0, walk(3.0)});
  for (StampedPose pose : sample(walk, 6.0, 0.1)) {
    if (pose.stamp_s > 4.95) trajectory.push_back(pose);
  }
  const TrajectorySpline spline(trajectory, 0.5);
  EXPECT_EQ(spline.coverage(-1e-6), Coverage::kBefore);
  EXPECT_EQ(spline.coverage(0.0), Coverage::kCovered);
  EXPECT_EQ(spline.coverage(1.5), Coverage::kInGap);
  EXPECT_EQ(spline.coverage(3.0), Coverage::kCovered);
  EXPECT_EQ(spline.coverage(6.1), Coverage::kAfter);
  EXPECT_EQ(TrajectorySpline().coverage(0.0), Coverage::kBefore);
  EXPECT_FALSE(spline.map_from_sensor(1.5));
  EXPECT_TRUE(spline.map_from_sensor(3.0));
  EXPECT_LT(worst_error(spline, walk, 0.0, 0.999).position_m, 0.002) << "the gap must not bend the curve";
  EXPECT_TRUE(TrajectorySpline(trajectory).map_from_sensor(1.5)) << "without a limit there is no gap";
}

}  // namespace
}  // namespace cpplus
