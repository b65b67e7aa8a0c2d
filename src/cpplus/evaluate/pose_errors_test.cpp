#include "cpplus/evaluate/pose_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

const Rigid3 kReference{Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2), Eigen::Vector3d(1, -2, 3)};

TEST(PoseErrors, OfAPoseWithItselfIsZero) {
  const PoseError error = pose_error(kReference, kReference);
  EXPECT_NEAR(error.rotation_deg, 0.0, 1e-12);
  EXPECT_NEAR(error.translation_m, 0.0, 1e-12);
}

TEST(PoseErrors, PureRotationAboutTheCameraCentreMovesNoCentre) {
  Vector6d delta = Vector6d::Zero();
  delta(1) = M_PI / 6;
  const PoseError error = pose_error(perturb_camera(kReference, delta), kReference);
  EXPECT_NEAR(error.rotation_deg, 30.0, 1e-9);
  EXPECT_NEAR(error.translation_m, 0.0, 1e-12);
}

TEST(PoseErrors, TranslationIsTheDistanceOfTheCentres) {
  // The stored translation of the estimate differs by 2 * 100 m here, the centres by 5 m.
  const Rigid3 reference{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ())),
                         Eigen::Vector3d(100, 0, 0)};                                   // centre (100, 0, 0)
  const Rigid3 estimate{Eigen::Quaterniond::Identity(), Eigen::Vector3d(-103, -4, 0)};  // centre (103, 4, 0)
  const PoseError error = pose_error(estimate, reference);
  EXPECT_NEAR(error.rotation_deg, 180.0, 1e-9);
  EXPECT_NEAR(error.translation_m, 5.0, 1e-12);
}

TEST(PoseErrors, AreSymmetric) {
  Vector6d delta;
  delta << 0.1, -0.2, 0.05, 1, 2, -0.5;
  const Rigid3 other = perturb_camera(kReference, delta);
  const PoseError there = pose_error(other, kReference);
  const PoseError back = pose_error(kReference, other);
  EXPECT_NEAR(there.rotation_deg, back.rotation_deg, 1e-9);
  EXPECT_NEAR(there.translation_m, back.translation_m, 1e-12);
  EXPECT_NEAR(there.translation_m, std::sqrt(5.25), 1e-12);
}

}  // namespace
}  // namespace cpplus
