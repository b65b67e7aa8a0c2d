#include "cpplus/pipeline/camera_velocity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

TEST(CameraVelocity, ForwardMotionIsAlongTheOpticalAxis) {
  Trajectory trajectory(2);
  trajectory[0].stamp_s = 10.0;
  trajectory[1].stamp_s = 12.0;
  trajectory[1].map_from_sensor.translation = Eigen::Vector3d(0, 0, 3);
  const TrajectorySpline way(trajectory);
  const auto velocity = camera_velocity(way, 11.0, Rigid3{});
  ASSERT_TRUE(velocity);
  Vector6d expected;
  expected << 0, 0, 0, 0, 0, 1.5;
  EXPECT_TRUE(velocity->isApprox(expected, 1e-6)) << velocity->transpose();
  EXPECT_TRUE(camera_velocity(way, 12.0, Rigid3{}));
}

TEST(CameraVelocity, NothingOutsideTheTrajectory) {
  Trajectory trajectory(2);
  trajectory[1].stamp_s = 1.0;
  const TrajectorySpline way(trajectory);
  EXPECT_FALSE(camera_velocity(way, -0.1, Rigid3{}));
  EXPECT_FALSE(camera_velocity(way, 1.1, Rigid3{}));
  EXPECT_FALSE(camera_velocity(TrajectorySpline({trajectory[0]}), 0.0, Rigid3{}));
}

/// A sensor that sways at 1.8 Hz as of a walker, poses at 10 Hz: the chord of a tenth of a second is 5 % too slow and
/// half a step late, which a curve is not.
TEST(CameraVelocity, FollowsSwayBetweenThePoses) {
  constexpr double kRate = 2.0 * M_PI * 1.8;  // rad/s
  constexpr double kSway = 0.02;              // rad
  Trajectory trajectory;
  for (int k = 0; k <= 30; ++k) {
    const double angle = kSway * std::sin(kRate * 0.1 * k);
    trajectory.push_back({0.1 * k, Rigid3(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
                                          Eigen::Vector3d::Zero())});
  }
  const TrajectorySpline way(trajectory);
  for (const double stamp : {0.51, 1.234, 2.25}) {
    const auto velocity = camera_velocity(way, stamp, inverse(*way.map_from_sensor(stamp)));
    ASSERT_TRUE(velocity);
    EXPECT_NEAR((*velocity)(1), kSway * kRate * std::cos(kRate * stamp), 0.04 * kSway * kRate) << stamp;
  }
}

}  // namespace
}  // namespace cpplus
