#include "cpplus/refine/pose_guess.h"

#include <gtest/gtest.h>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

Rigid3 some_pose() { return Rigid3(Eigen::Quaterniond(so3_exp({0.3, -1.1, 0.6})), Eigen::Vector3d(0.4, -2.0, 1.5)); }

Vector6d some_sigmas() {
  Vector6d sigmas;
  sigmas << 0.01, 0.02, 0.03, 0.1, 0.2, 0.4;
  return sigmas;
}

TEST(PoseGuess, HasTheSigmasThatItWasGiven) {
  const PoseGuess guess(some_pose(), some_sigmas());
  EXPECT_LT((guess.sigmas() - some_sigmas()).norm(), 1e-15);
  EXPECT_EQ(guess.covariance(0, 1), 0.0);
}

TEST(PoseGuess, TheSquaredDistanceCountsInSigmas) {
  const PoseGuess guess(some_pose(), some_sigmas());
  EXPECT_NEAR(guess.squared_distance(some_pose()), 0.0, 1e-20);
  for (int k = 0; k < 6; ++k) {
    const Vector6d delta = 2.0 * some_sigmas()(k) * Vector6d::Unit(k);
    EXPECT_NEAR(guess.squared_distance(perturb_camera(some_pose(), delta)), 4.0, 1e-9) << k;
  }
}

TEST(PoseGuess, CorrelationsCount) {
  // Two numbers of variance 1 and correlation 0.8: [1 1] costs 2 / 1.8, [1 -1] costs 2 / 0.2.
  Matrix6d covariance = Matrix6d::Identity();
  covariance(3, 4) = covariance(4, 3) = 0.8;
  const PoseGuess guess(Rigid3(), covariance);
  Vector6d along = Vector6d::Zero();
  along(3) = along(4) = 1.0;
  EXPECT_NEAR(guess.squared_distance(perturb_camera(Rigid3(), along)), 2.0 / 1.8, 1e-12);
  along(4) = -1.0;
  EXPECT_NEAR(guess.squared_distance(perturb_camera(Rigid3(), along)), 2.0 / 0.2, 1e-12);
}

TEST(PoseGuess, TheRootGivesTheCovariance) {
  Random random(1);
  Matrix6d m;
  for (double& value : m.reshaped()) value = random.normal();
  const PoseGuess guess(some_pose(), Matrix6d(m * m.transpose() + Matrix6d::Identity()));
  EXPECT_LT((guess.root() * guess.root().transpose() - guess.covariance).norm(), 1e-12 * guess.covariance.norm());
}

}  // namespace
}  // namespace cpplus
