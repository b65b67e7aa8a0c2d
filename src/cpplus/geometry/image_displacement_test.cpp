#include "cpplus/geometry/image_displacement.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

const Camera kCamera(CameraModel::kPinhole, 640, 480, {500, 500, 320, 240});

Rigid3 moved_by(const Eigen::Vector3d& translation) {
  Rigid3 pose;
  pose.translation = translation;
  return pose;
}

TEST(MeanDisplacement, IsFocalLengthTimesMotionOverDepth) {
  // 500 px * 4 cm / 2 m = 10 px and / 5 m = 4 px.
  EXPECT_NEAR(mean_displacement_px(kCamera, {{0, 0, 2}, {1, 0, 5}}, Rigid3(), moved_by({0.04, 0, 0})), 7.0, 1e-9);
  EXPECT_EQ(mean_displacement_px(kCamera, {{0, 0, 2}}, Rigid3(), Rigid3()), 0.0);
}

TEST(MeanDisplacement, PointsThatOnePoseDoesNotProjectDoNotCount) {
  EXPECT_NEAR(mean_displacement_px(kCamera, {{0, 0, 2}, {0, 0, -1}}, Rigid3(), moved_by({0.04, 0, 0})), 10.0, 1e-9);
  EXPECT_NEAR(mean_displacement_px(kCamera, {{0, 0, 0.5}}, Rigid3(), moved_by({0, 0, -1})), 0.0, 1e-9);
  EXPECT_EQ(mean_displacement_px(kCamera, {}, Rigid3(), moved_by({1, 0, 0})), 0.0);
}

}  // namespace
}  // namespace cpplus
