#include "cpplus/geometry/rigid3.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

const Rigid3 kPose{Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2), Eigen::Vector3d(1, -2, 3)};

TEST(Rigid3, QuarterTurnAboutZMovesXToY) {
  const Rigid3 b_from_a{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                        Eigen::Vector3d(10, 0, 0)};
  EXPECT_TRUE((b_from_a * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(10, 1, 0), 1e-12));
}

TEST(Rigid3, InverseUndoes) {
  const Eigen::Vector3d x(0.3, 5, -7);
  EXPECT_TRUE((inverse(kPose) * (kPose * x)).isApprox(x, 1e-12));
}

TEST(Rigid3, LogUndoesExpForSmallAndLargeAngles) {
  for (const double angle : {0.0, 1e-14, 1e-9, 1e-3, 1.0, 3.1}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(1, 2, -2) / 3.0;
    EXPECT_LT((so3_log(Eigen::Quaterniond(so3_exp(v))) - v).norm(), 1e-9) << angle;
  }
}

TEST(Rigid3, PerturbationIsInTheCameraFrame) {
  Vector6d delta = Vector6d::Zero();
  delta(5) = 0.5;  // half a metre along the optical axis
  const Rigid3 moved = perturb_camera(kPose, delta);
  const Eigen::Vector3d forward_in_map = kPose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(camera_center(moved).isApprox(camera_center(kPose) + 0.5 * forward_in_map, 1e-12));
}

TEST(Rigid3, APerturbationMovesPointsByItsDerivative) {
  const Eigen::Vector3d x_in_map(0.4, -1.3, 2.0);
  const auto derivative = d_camera_point_d_delta(kPose * x_in_map);
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = 1e-6 * Vector6d::Unit(k);
    const Eigen::Vector3d numeric =
        (perturb_camera(kPose, step) * x_in_map - perturb_camera(kPose, -step) * x_in_map) / 2e-6;
    EXPECT_LT((derivative.col(k) - numeric).norm(), 1e-7) << k;
  }
}

TEST(Rigid3, DifferenceUndoesPerturbation) {
  Vector6d delta;
  delta << 0.1, -0.2, 0.05, 1, 2, -0.5;
  EXPECT_TRUE(camera_difference(kPose, perturb_camera(kPose, delta)).isApprox(delta, 1e-12));
}

}  // namespace
}  // namespace cpplus
