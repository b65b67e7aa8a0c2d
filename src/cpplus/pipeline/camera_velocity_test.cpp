#include "cpplus/pipeline/camera_velocity.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(CameraVelocity, ForwardMotionIsAlongTheOpticalAxis) {
  Trajectory trajectory(2);
  trajectory[0].stamp_s = 10.0;
  trajectory[1].stamp_s = 12.0;
  trajectory[1].map_from_sensor.translation = Eigen::Vector3d(0, 0, 3);
  const TrajectorySpline spline(trajectory);
  const auto velocity = camera_velocity(spline, 11.0, Rigid3{});
  ASSERT_TRUE(velocity);
  Vector6d expected;
  expected << 0, 0, 0, 0, 0, 1.5;
  EXPECT_TRUE(velocity->isApprox(expected, 1e-6)) << velocity->transpose();
  EXPECT_TRUE(camera_velocity(spline, 12.0, Rigid3{}));
}

TEST(CameraVelocity, IsThatOfACameraCarriedAlong) {
  Trajectory trajectory;
  for (int i = 0; i < 12; ++i) {
    const double t = 0.1 * i;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * t, Eigen::Vector3d(0, 0.6, 0.8)));
    trajectory.push_back({t, Rigid3(turn, Eigen::Vector3d(t, t * t, 0))});
  }
  const TrajectorySpline spline(trajectory);
  const Rigid3 camera_from_sensor(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d(0.1, -2, 0.3));
  const auto camera_from_map = [&](double t) { return camera_from_sensor * inverse(*spline.map_from_sensor(t)); };
  const auto velocity = camera_velocity(spline, 0.63, camera_from_map(0.63));
  ASSERT_TRUE(velocity);
  constexpr double kStep = 1e-5;
  const Rigid3 now = camera_from_map(0.63);
  const Vector6d expected =
      (camera_difference(now, camera_from_map(0.63 + kStep)) - camera_difference(now, camera_from_map(0.63 - kStep))) /
      (2.0 * kStep);
  EXPECT_LT((*velocity - expected).norm(), 1e-6) << velocity->transpose() << "\n" << expected.transpose();
}

TEST(CameraVelocity, NothingOutsideTheTrajectory) {
  Trajectory trajectory(2);
  trajectory[1].stamp_s = 1.0;
  const TrajectorySpline spline(trajectory);
  EXPECT_FALSE(camera_velocity(spline, -0.1, Rigid3{}));
  EXPECT_FALSE(camera_velocity(spline, 1.1, Rigid3{}));
  EXPECT_FALSE(camera_velocity(TrajectorySpline({trajectory[0]}), 0.0, Rigid3{}));
}

}  // namespace
}  // namespace cpplus
