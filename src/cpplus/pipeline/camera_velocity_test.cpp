#include "cpplus/pipeline/camera_velocity.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(CameraVelocity, ForwardMotionIsAlongTheOpticalAxis) {
  Trajectory trajectory(2);
  trajectory[0].stamp_s = 10.0;
  trajectory[1].stamp_s = 12.0;
  trajectory[1].map_from_sensor.translation = Eigen::Vector3d(0, 0, 3);
  const auto velocity = camera_velocity(trajectory, 11.0, Rigid3{});
  ASSERT_TRUE(velocity);
  Vector6d expected;
  expected << 0, 0, 0, 0, 0, 1.5;
  EXPECT_TRUE(velocity->isApprox(expected, 1e-6)) << velocity->transpose();
  EXPECT_TRUE(camera_velocity(trajectory, 12.0, Rigid3{}));
}

TEST(CameraVelocity, NothingOutsideTheTrajectory) {
  Trajectory trajectory(2);
  trajectory[1].stamp_s = 1.0;
  EXPECT_FALSE(camera_velocity(trajectory, -0.1, Rigid3{}));
  EXPECT_FALSE(camera_velocity(trajectory, 1.1, Rigid3{}));
  EXPECT_FALSE(camera_velocity({trajectory[0]}, 0.0, Rigid3{}));
}

}  // namespace
}  // namespace cpplus
