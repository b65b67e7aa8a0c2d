#include "cpplus/refine/shared_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

struct Sequence {
  std::vector<PoseCorrection> corrections;
  std::vector<std::optional<Vector6d>> velocities;
};

Sequence make_sequence(int count, const Vector6d& extrinsic, double time_offset_s) {
  Random random(3);
  Sequence sequence;
  for (int i = 0; i < count; ++i) {
    Vector6d velocity;
    for (int k = 0; k < 6; ++k) velocity(k) = random.normal();
    PoseCorrection correction;
    correction.time = i;
    correction.correction = extrinsic + time_offset_s * velocity;
    correction.information = 1e6 * Matrix6d::Identity();
    correction.usable = true;
    sequence.corrections.push_back(correction);
    sequence.velocities.push_back(velocity);
  }
  return sequence;
}

Vector6d prior() {
  Vector6d sigmas;
  sigmas << 0.02, 0.02, 0.02, 0.1, 0.1, 0.1;
  return sigmas;
}

TEST(SharedErrors, FindsExtrinsicAndTimeOffset) {
  Vector6d extrinsic;
  extrinsic << 0.01, -0.005, 0.002, 0.03, 0.0, -0.05;
  const Sequence sequence = make_sequence(20, extrinsic, 0.02);
  const auto shared = estimate_shared_errors(sequence.corrections, sequence.velocities, prior(), {});
  ASSERT_TRUE(shared);
  EXPECT_NEAR(shared->time_offset_s, 0.02, 1e-3);
  EXPECT_LT((shared->extrinsic - extrinsic).norm(), 2e-3);
  EXPECT_EQ(shared->num_images, 20);
}

TEST(SharedErrors, OneWrongImageDoesNotDecide) {
  Sequence sequence = make_sequence(20, Vector6d::Zero(), 0.02);
  sequence.corrections[7].correction(3) += 1.0;
  const auto shared = estimate_shared_errors(sequence.corrections, sequence.velocities, prior(), {});
  ASSERT_TRUE(shared);
  EXPECT_NEAR(shared->time_offset_s, 0.02, 2e-3);
  EXPECT_LT(shared->extrinsic.norm(), 5e-3);
}

TEST(SharedErrors, StandingCameraLeavesTheTimeOffsetToItsPrior) {
  Sequence sequence = make_sequence(20, Vector6d::Zero(), 0.0);
  for (auto& velocity : sequence.velocities) velocity = Vector6d::Zero();
  const auto shared = estimate_shared_errors(sequence.corrections, sequence.velocities, prior(), {});
  ASSERT_TRUE(shared);
  EXPECT_NEAR(shared->time_offset_sigma_s, 0.1, 1e-6);
}

TEST(SharedErrors, TooFewImagesGiveNothing) {
  Sequence sequence = make_sequence(5, Vector6d::Zero(), 0.0);
  sequence.velocities[0].reset();
  sequence.corrections[1].usable = false;
  EXPECT_FALSE(estimate_shared_errors(sequence.corrections, sequence.velocities, prior(), {}));
}

}  // namespace
}  // namespace cpplus
