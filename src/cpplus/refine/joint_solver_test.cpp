#include "cpplus/refine/joint_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"
#include "cpplus/refine/pose_search.h"

namespace cpplus {
namespace {

const Vector6d kPrior = PosePrior().sigmas();

Vector6d common_error() {
  Vector6d error;
  error << 0.8, -0.5, 0.3, 0.6, -0.9, 0.2;
  return error.cwiseProduct(kPrior);
}

Vector6d drawn(const Vector6d& sigmas, Random* random) {
  Vector6d result;
  for (int k = 0; k < 6; ++k) result(k) = sigmas(k) * random->normal();
  return result;
}

double in_prior_sigmas(const Vector6d& difference) { return difference.cwiseQuotient(kPrior).cwiseAbs().maxCoeff(); }

Rigid3 coarse_pose(size_t i) {
  const double at = static_cast<double>(i);
  return Rigid3(Eigen::Quaterniond(so3_exp({0.02 * at, -1.1, 0.03 * at})), Eigen::Vector3d(0.4 * at, -0.1 * at, 1.5));
}

PoseObservation observe(const Rigid3& coarse, const Vector6d& correction, const Vector6d& sigmas) {
  return {perturb_camera(coarse, correction), Matrix6d(sigmas.cwiseAbs2().cwiseInverse().asDiagonal())};
}

/// Images of one camera, one second apart, whose poses are known to a tenth of the prior.
struct Sequence {
  JointProblem problem;
  std::vector<Vector6d> truth;  // corrections of the coarse poses

  Sequence(size_t count, const std::function<Vector6d(size_t)>& correction_of, double observed_sigma = 0.1,
           uint64_t seed = 5) {
    Random random(seed);
    for (size_t i = 0; i < count; ++i) {
      truth.push_back(correction_of(i));
      JointImage image;
      image.camera_id = 1;
      image.coarse_camera_from_map = image.camera_from_map = coarse_pose(i);
      const Vector6d sigmas = observed_sigma * kPrior;
      image.observed = observe(coarse_pose(i), truth.back() + drawn(sigmas, &random), sigmas);
      problem.images.push_back(image);
      problem.sequences[1].emplace_back(static_cast<double>(i), i);
    }
  }

  JointResult solve(const JointOptions& options = {}) const { return solve_joint(problem, kPrior, {}, options); }

  // How far a pose is from the truth, in sigmas of the prior.
  double error(size_t i, const Rigid3& pose) const {
    return in_prior_sigmas(camera_difference(perturb_camera(coarse_pose(i), truth[i]), pose));
  }
};

TEST(SolveJoint, AnErrorCommonToAllPredictsTheImageThatFailed) {
  Sequence sequence(12, [](size_t) { return common_error(); });
  sequence.problem.images[5].observed.reset();
  const JointResult result = sequence.solve();
  ASSERT_EQ(result.poses.size(), 12u);
  const PoseGuess& expected = result.poses[5].from_others;
  EXPECT_LT(sequence.error(5, expected.camera_from_map), 0.15);
  EXPECT_LT(in_prior_sigmas(expected.sigmas()), 0.5);
  // All that is known of it comes from the others.
  EXPECT_LT(in_prior_sigmas(camera_difference(expected.camera_from_map, result.poses[5].camera_from_map)), 1e-6);
  EXPECT_LT((expected.covariance - result.poses[5].covariance).norm(), 1e-6 * expected.covariance.norm());
  EXPECT_LT((result.poses[5].covariance_from_others - result.poses[5].covariance).norm(),
            1e-6 * expected.covariance.norm());
  // An image that saw something is better known with that than without.
  const JointPose& seen = result.poses[4];
  EXPECT_GT(in_prior_sigmas(PoseGuess(seen.camera_from_map, seen.covariance_from_others).sigmas()),
            1.05 * in_prior_sigmas(PoseGuess(seen.camera_from_map, seen.covariance).sigmas()));
}

TEST(SolveJoint, AnImageThatContradictsItsNeighboursStandsOutAndMisleadsNone) {
  Sequence sequence(12, [](size_t) { return common_error(); });
  sequence.problem.images[7].observed = observe(coarse_pose(7), -2.0 * common_error(), 0.1 * kPrior);
  const JointResult result = sequence.solve();
  const auto contradiction = [&](size_t i) {
    return result.poses[i].from_others.squared_distance(sequence.problem.images[i].observed->camera_from_map);
  };
  for (size_t i = 0; i < 12; ++i) {
    EXPECT_LT(sequence.error(i, result.poses[i].camera_from_map), 0.3) << i;
    EXPECT_LT(sequence.error(i, result.poses[i].from_others.camera_from_map), 0.3) << i;
    EXPECT_TRUE(i == 7 || contradiction(i) < contradiction(7) / 3) << i;
  }
}

TEST(SolveJoint, ADriftIsFollowed) {
  Sequence sequence(30, [](size_t i) { return Vector6d(std::sin(0.2 * static_cast<double>(i)) * common_error()); });
  sequence.problem.images[14].observed.reset();
  const JointResult result = sequence.solve();
  EXPECT_LT(sequence.error(14, result.poses[14].from_others.camera_from_map), 0.3);
  for (size_t i = 0; i < 30; ++i) EXPECT_LT(sequence.error(i, result.poses[i].camera_from_map), 0.35) << i;
}

TEST(SolveJoint, IndependentErrorsPredictLittle) {
  Random random(9);
  const Sequence sequence(30, [&](size_t) { return drawn(kPrior, &random); });
  const JointResult result = sequence.solve();
  for (size_t i = 0; i < 30; ++i) {
    EXPECT_GT(result.poses[i].from_others.sigmas().cwiseQuotient(kPrior).minCoeff(), 0.3) << i;
    EXPECT_LT(sequence.error(i, result.poses[i].camera_from_map), 0.5) << i;
  }
}

TEST(SolveJoint, FewImagesPredictWithTheUncertaintyOfFew) {
  Sequence sequence(3, [](size_t) { return common_error(); });
  sequence.problem.images[1].observed.reset();
  sequence.problem.images[2].observed.reset();
  const JointResult result = sequence.solve();
  EXPECT_LT(sequence.error(2, result.poses[2].from_others.camera_from_map), 1.0);

  Sequence alone(1, [](size_t) { return common_error(); });
  EXPECT_LT(alone.error(0, alone.solve().poses[0].camera_from_map), 0.3);
  EXPECT_TRUE(solve_joint({}, kPrior, {}, {}).poses.empty());
}

TEST(SolveJoint, WithoutAnyEvidenceTheCoarsePosesStay) {
  Sequence sequence(4, [](size_t) { return common_error(); });
  for (JointImage& image : sequence.problem.images) image.observed.reset();
  const JointResult result = sequence.solve();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT(camera_difference(coarse_pose(i), result.poses[i].camera_from_map).norm(), 1e-9);
    EXPECT_GT(result.poses[i].from_others.sigmas().cwiseQuotient(kPrior).minCoeff(), 0.5) << i;
  }
}

TEST(SolveJoint, SeveralImagesOfOneInstantAreNoDivisionByZero) {
  Sequence sequence(8, [](size_t) { return common_error(); });
  for (auto& [time, i] : sequence.problem.sequences[1]) time = 3.0;
  const JointResult result = sequence.solve();
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_TRUE(result.poses[i].covariance.allFinite());
    EXPECT_TRUE(result.poses[i].from_others.covariance.allFinite());
    EXPECT_LT(sequence.error(i, result.poses[i].camera_from_map), 0.3);
    EXPECT_LT(sequence.error(i, result.poses[i].from_others.camera_from_map), 0.3);
  }
}

TEST(SolveJoint, ImagesInNoSequenceKeepTheirPose) {
  Sequence sequence(6, [](size_t) { return common_error(); });
  JointProblem& problem = sequence.problem;
  problem.sequences[1].erase(problem.sequences[1].begin() + 2);  // observed, and yet it has no part
  problem.images[3].observed.reset();
  const JointResult result = sequence.solve();
  ASSERT_EQ(result.poses.size(), 6u);
  EXPECT_EQ(result.poses[2].camera_from_map.translation, coarse_pose(2).translation);
  EXPECT_EQ(result.poses[2].camera_from_map.rotation.coeffs(), coarse_pose(2).rotation.coeffs());
  EXPECT_LT(sequence.error(3, result.poses[3].camera_from_map), 0.2) << "the others do without it";
  EXPECT_EQ(result.shared.at(1).num_images, 5);
}

TEST(SolveJoint, CamerasHaveErrorsOfTheirOwn) {
  Sequence sequence(20, [](size_t i) { return Vector6d((i % 2 == 0 ? 1.0 : -1.0) * common_error()); });
  JointProblem& problem = sequence.problem;
  problem.sequences.clear();
  for (size_t i = 0; i < 20; ++i) {
    problem.images[i].camera_id = i % 2 == 0 ? 1 : 2;
    problem.sequences[problem.images[i].camera_id].emplace_back(static_cast<double>(i), i);
  }
  problem.images[8].observed.reset();
  problem.images[11].observed.reset();
  const JointResult result = sequence.solve();
  for (size_t i : {8, 11}) EXPECT_LT(sequence.error(i, result.poses[i].from_others.camera_from_map), 0.15) << i;
  ASSERT_EQ(result.shared.size(), 2u);
  EXPECT_LT(in_prior_sigmas(result.shared.at(1).extrinsic - common_error()), 0.3);
  EXPECT_LT(in_prior_sigmas(result.shared.at(2).extrinsic + common_error()), 0.3);
}

// A camera that moves irregularly, with these errors and precise observations.
Sequence moving(const Vector6d& extrinsic, double time_offset_s) {
  Random random(3);
  std::vector<Vector6d> velocities;
  for (int i = 0; i < 20; ++i) velocities.push_back(drawn(Vector6d::Ones(), &random));
  Sequence sequence(
      20, [&](size_t i) { return Vector6d(extrinsic + time_offset_s * velocities[i]); }, 0.02);
  for (size_t i = 0; i < 20; ++i) sequence.problem.images[i].velocity_per_s = velocities[i];
  return sequence;
}

Vector6d some_extrinsic() {
  Vector6d extrinsic;
  extrinsic << 0.01, -0.005, 0.002, 0.03, 0.0, -0.05;
  return extrinsic;
}

TEST(SharedErrors, ExtrinsicAndTimeOffsetAreFound) {
  const SharedErrors shared = moving(some_extrinsic(), 0.02).solve().shared.at(1);
  EXPECT_NEAR(shared.time_offset_s, 0.02, 1e-3);
  EXPECT_LT(in_prior_sigmas(shared.extrinsic - some_extrinsic()), 0.05);
  EXPECT_LT(shared.time_offset_sigma_s, 2e-3);
  EXPECT_LT(in_prior_sigmas(shared.extrinsic_sigmas), 0.1);
  EXPECT_EQ(shared.num_images, 20);
}

TEST(SharedErrors, TheyPredictAnImageThatFailed) {
  Sequence sequence = moving(some_extrinsic(), 0.02);
  sequence.problem.images[13].observed.reset();
  EXPECT_LT(sequence.error(13, sequence.solve().poses[13].from_others.camera_from_map), 0.1);
}

TEST(SharedErrors, OneWrongImageDoesNotDecide) {
  Sequence sequence = moving(Vector6d::Zero(), 0.02);
  Vector6d wrong = sequence.truth[7];
  wrong(3) += 1.0;
  sequence.problem.images[7].observed = observe(coarse_pose(7), wrong, 0.02 * kPrior);
  const JointResult result = sequence.solve();
  EXPECT_NEAR(result.shared.at(1).time_offset_s, 0.02, 2e-3);
  EXPECT_LT(in_prior_sigmas(result.shared.at(1).extrinsic), 0.1);
  for (size_t i = 0; i < 20; ++i) EXPECT_LT(sequence.error(i, result.poses[i].camera_from_map), 0.15) << i;
}

TEST(SharedErrors, AStandingCameraLeavesTheTimeOffsetAtItsPrior) {
  Sequence sequence(20, [](size_t) { return common_error(); });
  for (JointImage& image : sequence.problem.images) image.velocity_per_s = Vector6d::Zero();
  JointOptions options;
  options.time_offset_sigma_s = 0.07;
  const SharedErrors shared = sequence.solve(options).shared.at(1);
  EXPECT_NEAR(shared.time_offset_sigma_s, 0.07, 1e-9);
  EXPECT_NEAR(shared.time_offset_s, 0.0, 1e-9);
}

// Mean over drawings of the squared error in units of the covariance, where 6 is right: of the poses, and of what the
// others say of an image that has nothing of its own.
struct Calibration {
  double solved = 0.0;
  double predicted = 0.0;
};

Calibration calibrate(const std::function<Vector6d(size_t, Random*)>& correction_of, double observed_sigma) {
  constexpr int kDrawings = 40;  // a mean of 40 of them is good to 0.55
  constexpr size_t kImages = 20, kFailed = 9;
  JointOptions options;
  options.covariance_inflation = 1.0;  // the observations are as good as they say
  Calibration sum;
  for (int drawing = 0; drawing < kDrawings; ++drawing) {
    Random random(1000 + static_cast<uint64_t>(drawing));
    Sequence sequence(
        kImages, [&](size_t i) { return correction_of(i, &random); }, observed_sigma, static_cast<uint64_t>(drawing));
    sequence.problem.images[kFailed].observed.reset();
    const JointResult result = sequence.solve(options);
    for (size_t i = 0; i < kImages; ++i) {
      const Rigid3 truth = perturb_camera(coarse_pose(i), sequence.truth[i]);
      const PoseGuess solved{result.poses[i].camera_from_map, result.poses[i].covariance};
      if (i == kFailed) {
        sum.predicted += solved.squared_distance(truth) / kDrawings;
      } else {
        sum.solved += solved.squared_distance(truth) / (kDrawings * (kImages - 1));
      }
    }
  }
  return sum;
}

TEST(SolveJoint, TheCovarianceIsThatOfTheErrorsForACommonError) {
  Vector6d common;
  const Calibration c = calibrate(
      [&](size_t i, Random* random) {
        if (i == 0) common = drawn(kPrior, random);
        return common;
      },
      0.3);
  // Where there is no drift at all, expectation maximisation comes down to it slowly: the program errs to the side of
  // caution.
  EXPECT_GT(c.solved, 2.0);
  EXPECT_LT(c.solved, 7.5);
  EXPECT_GT(c.predicted, 1.0);
  EXPECT_LT(c.predicted, 7.5);
}

TEST(SolveJoint, TheCovarianceIsThatOfTheErrorsForIndependentErrors) {
  const Calibration c = calibrate([](size_t, Random* random) { return drawn(kPrior, random); }, 0.2);
  EXPECT_GT(c.solved, 4.5);
  EXPECT_LT(c.solved, 7.5);
  EXPECT_GT(c.predicted, 3.5);
  EXPECT_LT(c.predicted, 10.0);
}

TEST(SolveJoint, TheCovarianceIsThatOfTheErrorsForADrift) {
  Vector6d walk;
  const Calibration c = calibrate(
      [&](size_t i, Random* random) {
        walk = i == 0 ? drawn(0.7 * kPrior, random) : Vector6d(walk + drawn(0.25 * kPrior, random));
        return walk;
      },
      0.2);
  EXPECT_GT(c.solved, 4.5);
  EXPECT_LT(c.solved, 7.5);
  EXPECT_GT(c.predicted, 3.0);
  EXPECT_LT(c.predicted, 10.0);
}

TEST(JointOptions, ValuesOutOfRangeAreErrors) {
  EXPECT_NO_THROW(JointOptions().validate());
  const auto expect_refused = [](const std::function<void(JointOptions*)>& spoil) {
    JointOptions options;
    spoil(&options);
    EXPECT_THROW(options.validate(), Error);
  };
  expect_refused([](JointOptions* o) { o->rounds = 0; });
  expect_refused([](JointOptions* o) { o->patch_sigma_px = 0.0; });
  expect_refused([](JointOptions* o) { o->plane_sigma_px = -1.0; });
  expect_refused([](JointOptions* o) { o->time_offset_sigma_s = 0.0; });
  expect_refused([](JointOptions* o) { o->covariance_inflation = 0.9; });
}

}  // namespace
}  // namespace cpplus
