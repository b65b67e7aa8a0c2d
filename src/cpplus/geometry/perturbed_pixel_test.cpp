#include "cpplus/geometry/perturbed_pixel.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(ProjectPerturbed, DerivativesAreThoseOfDifferences) {
  const Camera camera(CameraModel::kOpenCv, 640, 480, {400, 410, 320, 240, -0.2, 0.05, 0.001, -0.002});
  const Rigid3 pose(Eigen::Quaterniond(so3_exp({0.3, -1.1, 0.6})), Eigen::Vector3d(0.4, -2.0, 1.5));
  const Eigen::Vector3d x_in_map = inverse(pose) * Eigen::Vector3d(0.4, -0.3, 2.5);
  const auto seen = project_perturbed(camera, pose * x_in_map);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->pixel, *camera.project(pose * x_in_map));
  constexpr double kStep = 1e-6;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const Vector6d delta = kStep * Vector6d::Unit(k);
    const Eigen::Vector2d difference = *camera.project(perturb_camera(pose, delta) * x_in_map) -
                                       *camera.project(perturb_camera(pose, -delta) * x_in_map);
    EXPECT_LT((difference / (2.0 * kStep) - seen->by_perturbation.col(k)).norm(), 1e-4) << k;
  }
}

TEST(ProjectPerturbed, NothingBehindAPinhole) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {400, 400, 320, 240});
  EXPECT_FALSE(project_perturbed(camera, {0.1, 0.2, -1.0}));
}

}  // namespace
}  // namespace cpplus
