#include "cpplus/evaluate/trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, z)}; }

const std::vector<Rigid3> kReference = {at(0, 0, 0), at(1, 0, 0), at(1, 2, 0), at(1, 2, 3)};

/// Applies x' = scale * rotation * x + translation to a trajectory.
std::vector<Rigid3> transformed(const std::vector<Rigid3>& poses, double scale, const Rigid3& motion) {
  std::vector<Rigid3> result;
  for (const Rigid3& pose : poses) {
    result.push_back(
        {motion.rotation * pose.rotation, scale * (motion.rotation * pose.translation) + motion.translation});
  }
  return result;
}

double ate_m(const std::vector<Rigid3>& estimate, TrajectoryAlignment alignment) {
  const auto transform = align_trajectory(estimate, kReference, alignment);
  EXPECT_TRUE(transform);
  return absolute_trajectory_error(estimate, kReference, *transform).translation_m.rms;
}

TEST(AbsoluteTrajectoryError, WithoutAlignmentByHand) {
  std::vector<Rigid3> estimate = kReference;
  estimate[1] = at(1, 3, 4);  // 5 m off
  estimate[2].rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  const TrajectoryError error = absolute_trajectory_error(estimate, kReference, {});
  EXPECT_NEAR(error.translation_m.rms, 2.5, 1e-12);  // sqrt(25 / 4)
  EXPECT_NEAR(error.rotation_deg.rms, 45.0, 1e-9);   // sqrt(90^2 / 4)
  EXPECT_NEAR(error.translation_m.max, 5.0, 1e-12);
}

TEST(AlignTrajectory, Sim3TakesOutScaleRotationAndTranslation) {
  const Rigid3 motion{Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3), Eigen::Vector3d(4, -5, 6)};
  const auto estimate = transformed(kReference, 0.25, motion);
  const auto transform = align_trajectory(estimate, kReference, TrajectoryAlignment::kSim3);
  ASSERT_TRUE(transform);
  EXPECT_NEAR(transform->scale, 4.0, 1e-9);
  const TrajectoryError error = absolute_trajectory_error(estimate, kReference, *transform);
  EXPECT_NEAR(error.translation_m.rms, 0.0, 1e-9);
  EXPECT_NEAR(error.rotation_deg.rms, 0.0, 1e-6);
  EXPECT_GT(ate_m(estimate, TrajectoryAlignment::kSe3), 0.5);  // SE(3) cannot take out a scale
}

TEST(AlignTrajectory, Se3TakesOutAnyRotationButPositionYawDoesNot) {
  const Rigid3 motion{Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3), Eigen::Vector3d(4, -5, 6)};
  const auto estimate = transformed(kReference, 1.0, motion);
  EXPECT_NEAR(ate_m(estimate, TrajectoryAlignment::kSe3), 0.0, 1e-9);
  EXPECT_GT(ate_m(estimate, TrajectoryAlignment::kPositionYaw), 0.5);
}

TEST(AlignTrajectory, PositionYawTakesOutYawAndTranslation) {
  const Rigid3 motion{Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ())), Eigen::Vector3d(4, -5, 6)};
  const auto estimate = transformed(kReference, 1.0, motion);
  EXPECT_NEAR(ate_m(estimate, TrajectoryAlignment::kPositionYaw), 0.0, 1e-9);
  const auto transform = align_trajectory(estimate, kReference, TrajectoryAlignment::kPositionYaw);
  EXPECT_NEAR(transform->rotation.angularDistance(motion.rotation.conjugate()), 0.0, 1e-9);
}

TEST(AlignTrajectory, NeverReturnsAReflection) {
  // The mirror image of four points in general position: a reflection would fit exactly, a rotation cannot.
  std::vector<Rigid3> mirrored = kReference;
  for (Rigid3& pose : mirrored) pose.translation.x() *= -1;
  const auto transform = align_trajectory(mirrored, kReference, TrajectoryAlignment::kSe3);
  ASSERT_TRUE(transform);
  EXPECT_NEAR(transform->rotation.toRotationMatrix().determinant(), 1.0, 1e-9);
  EXPECT_GT(absolute_trajectory_error(mirrored, kReference, *transform).translation_m.rms, 0.1);
}

TEST(AlignTrajectory, IsTheLeastSquaresOptimum) {
  std::vector<Rigid3> estimate = kReference;
  estimate[0].translation += Eigen::Vector3d(0.3, -0.1, 0.2);
  estimate[3].translation += Eigen::Vector3d(-0.2, 0.4, 0.1);
  const auto best = align_trajectory(estimate, kReference, TrajectoryAlignment::kSe3);
  ASSERT_TRUE(best);
  const double best_rms = absolute_trajectory_error(estimate, kReference, *best).translation_m.rms;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-0.01, 0.01}) {
      Similarity3 turned = *best;
      turned.rotation = Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(axis)) * turned.rotation;
      Similarity3 moved = *best;
      moved.translation(axis) += step;
      EXPECT_GT(absolute_trajectory_error(estimate, kReference, turned).translation_m.rms, best_rms);
      EXPECT_GT(absolute_trajectory_error(estimate, kReference, moved).translation_m.rms, best_rms);
    }
  }
}

TEST(AlignTrajectory, GivesNothingWhereThePositionsDoNotDetermineIt) {
  const std::vector<Rigid3> line = {at(0, 0, 0), at(1, 1, 0), at(2, 2, 0)};
  EXPECT_FALSE(align_trajectory(line, line, TrajectoryAlignment::kSe3));
  EXPECT_FALSE(align_trajectory(line, line, TrajectoryAlignment::kSim3));
  EXPECT_TRUE(align_trajectory(line, line, TrajectoryAlignment::kPositionYaw));
  const std::vector<Rigid3> mast = {at(3, 4, 0), at(3, 4, 1)};
  EXPECT_FALSE(align_trajectory(mast, mast, TrajectoryAlignment::kPositionYaw));
  EXPECT_FALSE(align_trajectory({}, {}, TrajectoryAlignment::kNone));
}

TEST(AlignTrajectory, RejectsListsOfDifferentLength) {
  EXPECT_THROW(align_trajectory(kReference, {}, TrajectoryAlignment::kSe3), Error);
}

TEST(PosePairs, ByStepAndByLength) {
  EXPECT_EQ(pose_pairs_by_step(4, 2), (PosePairs{{0, 2}, {1, 3}}));
  EXPECT_TRUE(pose_pairs_by_step(2, 5).empty());
  // The path positions of kReference are 0, 1, 3, 6 m.
  EXPECT_EQ(pose_pairs_by_length(kReference, 2.0), (PosePairs{{0, 2}, {1, 2}, {2, 3}}));
  EXPECT_EQ(pose_pairs_by_length(kReference, 5.0), (PosePairs{{0, 3}, {1, 3}}));
}

TEST(RelativePoseError, IgnoresARigidMotionOfTheWholeTrajectory) {
  const Rigid3 motion{Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3), Eigen::Vector3d(4, -5, 6)};
  const TrajectoryError error =
      relative_pose_error(transformed(kReference, 1.0, motion), kReference, pose_pairs_by_step(4, 1));
  EXPECT_EQ(error.translation_m.count, 3u);
  EXPECT_NEAR(error.translation_m.rms, 0.0, 1e-9);
  EXPECT_NEAR(error.rotation_deg.rms, 0.0, 1e-6);
}

TEST(RelativePoseError, OfOneJumpByHand) {
  std::vector<Rigid3> estimate = kReference;
  for (size_t i = 2; i < 4; ++i) estimate[i].translation.z() += 0.6;  // a jump between poses 1 and 2
  const TrajectoryError error = relative_pose_error(estimate, kReference, pose_pairs_by_step(4, 1));
  EXPECT_NEAR(error.translation_m.max, 0.6, 1e-12);
  EXPECT_NEAR(error.translation_m.mean, 0.2, 1e-12);
  EXPECT_NEAR(error.translation_m.median, 0.0, 1e-12);
}

TEST(RelativePoseError, ScalesTheEstimate) {
  const TrajectoryError error =
      relative_pose_error(transformed(kReference, 0.5, {}), kReference, pose_pairs_by_step(4, 1), 2.0);
  EXPECT_NEAR(error.translation_m.rms, 0.0, 1e-12);
}

}  // namespace
}  // namespace cpplus
