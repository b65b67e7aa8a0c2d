#include "cpplus/refine/joint_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// An image of the furnished room, and points of the room that it sees.
struct View {
  TestRoom room = furnished_room();
  EdgeEvidence edges;
  std::vector<Eigen::Vector3d> surface_in_map;

  explicit View(const DrawnNoise& noise = {}) {
    const Camera camera = test_camera();
    const PlaneBuffer planes = cast_plane_buffer(room, camera, true_view());
    const auto samples = sample_visible_edges(room.edges, camera, true_view(), planes, {});
    edges =
        EdgeEvidence(camera, true_view(), room.edges, samples, draw_room(room, camera, true_view(), noise), 24.0, 15.0);
    for (double y = 20; y < camera.height(); y += 40) {
      for (double x = 20; x < camera.width(); x += 40) {
        const int32_t plane = planes.plane_at({x, y});
        const double range = planes.range_of(room.planes[static_cast<size_t>(plane)], {x, y});
        surface_in_map.push_back(inverse(true_view()) * Eigen::Vector3d(range * *camera.unproject({x, y})));
      }
    }
  }
};

Matrix6d variances(double rotation_deg, double translation_m) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(rotation_deg * std::numbers::pi / 180.0),
      Eigen::Vector3d::Constant(translation_m);
  return sigmas.cwiseAbs2().asDiagonal();
}

const Matrix6d kWellKnown = variances(0.03, 0.003);
const Matrix6d kAsCoarse = variances(1.0, 0.10);

JointCandidate candidate_at(const View& view, const Rigid3& pose, const Matrix6d& covariance, const Matrix6d& others) {
  JointCandidate candidate;
  candidate.coarse_camera_from_map = disturbed(true_view(), 1.0, 0.10, 3);
  candidate.pose.camera_from_map = pose;
  candidate.pose.covariance = covariance;
  candidate.pose.from_others = {pose, others};
  candidate.edges = &view.edges;
  candidate.surface_in_map = view.surface_in_map;
  return candidate;
}

RefinePoseResult judge(const JointCandidate& candidate, const RefinePoseOptions& options = {}) {
  return judge_joint_pose(test_camera(), candidate, {}, options);
}

void expect_refused(const RefinePoseResult& result, const JointCandidate& candidate, const char* reason) {
  EXPECT_EQ(result.status, RefineStatus::kKeptCoarse);
  EXPECT_THAT(result.reason, HasSubstr(reason));
  EXPECT_EQ(result.camera_from_map.translation, candidate.coarse_camera_from_map.translation);
  EXPECT_EQ(result.camera_from_map.rotation.coeffs(), candidate.coarse_camera_from_map.rotation.coeffs());
  EXPECT_EQ(result.candidate_camera_from_map.translation, candidate.pose.camera_from_map.translation);
}

/// What an image shows that is of somewhere else.
View clutter() {
  DrawnNoise noise;
  noise.room = false;
  noise.clutter_chains = 600;
  return View(noise);
}

TEST(JointVerdict, AGoodPoseIsAccepted) {
  const View view;
  const RefinePoseResult result = judge(candidate_at(view, true_view(), kWellKnown, kAsCoarse));
  EXPECT_EQ(result.status, RefineStatus::kRefined) << result.reason;
  EXPECT_THAT(result.reason, IsEmpty());
  EXPECT_EQ(result.camera_from_map.translation, true_view().translation);
  EXPECT_EQ(result.covariance, kWellKnown);
  EXPECT_EQ(result.num_samples, static_cast<int>(view.edges.num_samples()));
  EXPECT_GT(result.num_matches, result.num_samples / 2);
  EXPECT_GT(result.num_edges, 10);
  EXPECT_LT(result.after.median_px, 0.6);
  EXPECT_LT(result.held_out_after.median_px, 1.0);
  EXPECT_EQ(result.held_out_after.num_samples, result.num_samples) << "each sample is held out once";
  EXPECT_GT(result.held_out_after.log_ratio, 30.0);
  EXPECT_THAT(result.weak_directions, IsEmpty());
  EXPECT_GT(result.information_eigenvalues(0), 1.0);
}

TEST(JointVerdict, AnUncertainPoseIsRefused) {
  const View view;
  const JointCandidate candidate = candidate_at(view, true_view(), variances(0.5, 0.05), kAsCoarse);
  const RefinePoseResult result = judge(candidate);
  EXPECT_GT(result.predicted_shift_px, RefinePoseOptions().max_predicted_shift_px);
  expect_refused(result, candidate, "uncertain");
  RefinePoseOptions lenient;
  lenient.max_predicted_shift_px = 20.0;
  EXPECT_EQ(judge(candidate, lenient).status, RefineStatus::kRefined);
}

TEST(JointVerdict, AnUncertainPoseIsAcceptedFarFromTheCoarseOne) {
  const View view;
  JointCandidate candidate = candidate_at(view, true_view(), variances(0.5, 0.05), kAsCoarse);
  const double predicted_px = judge(candidate).predicted_shift_px;
  // A camera that is turned by 0.2 rad sees the surface some tens of pixels away.
  Vector6d turn = Vector6d::Zero();
  turn(1) = 0.2;
  candidate.coarse_camera_from_map = perturb_camera(true_view(), turn);
  const double way_px = 0.2 * test_camera().pixels_per_radian();
  EXPECT_LT(predicted_px, 0.35 * way_px);
  const RefinePoseResult result = judge(candidate);
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  EXPECT_THAT(result.reason, HasSubstr("nearer than the coarse pose"));
  RefinePoseOptions strict;
  strict.max_predicted_share = 0.0;
  expect_refused(judge(candidate, strict), candidate, "uncertain");
}

TEST(JointVerdict, WhereItsEdgesLeaveADirectionOpenAnUncertainPoseMustHaveComeFarther) {
  const View view;
  RefinePoseOptions sure;  // of the coarse pose: what the edges know is then little
  sure.prior = {0.005, 0.0005};
  JointCandidate candidate = candidate_at(view, true_view(), variances(0.5, 0.05), kAsCoarse);
  const double predicted_px = judge(candidate).predicted_shift_px;
  Vector6d turn = Vector6d::Zero();
  const auto verdict = [&](double ways, const RefinePoseOptions& options) {
    turn(1) = ways * predicted_px / test_camera().pixels_per_radian();
    candidate.coarse_camera_from_map = perturb_camera(true_view(), turn);
    return judge(candidate, options).status;
  };
  // The surface is seen at up to 40 degrees, where a turn moves it farther than on the axis: limits are 1.3 and 1.9
  // ways.
  EXPECT_EQ(verdict(0.8, {}), RefineStatus::kKeptCoarse);
  EXPECT_EQ(verdict(1.4, {}), RefineStatus::kRefined);
  EXPECT_EQ(verdict(1.15, sure), RefineStatus::kKeptCoarse);
  EXPECT_EQ(verdict(2.0, sure), RefineStatus::kRefined);
  // Where most images do not prove where they are, no way makes up for it.
  candidate.most_are_proven = false;
  EXPECT_EQ(verdict(2.0, {}), RefineStatus::kKeptCoarse);
}

TEST(JointVerdict, AnImageThatSeesNoSurfaceIsRefused) {
  const View view;
  JointCandidate candidate = candidate_at(view, true_view(), kWellKnown, kAsCoarse);
  candidate.surface_in_map.clear();
  const RefinePoseResult result = judge(candidate);
  EXPECT_EQ(result.predicted_shift_px, std::numeric_limits<double>::infinity());
  expect_refused(result, candidate, "uncertain");
}

TEST(JointVerdict, AWrongPoseIsRefusedByItsEdges) {
  const View view;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    const Rigid3 wrong = disturbed(true_view(), 8.0, 0.8, seed);
    const JointCandidate candidate = candidate_at(view, wrong, kWellKnown, kAsCoarse);
    const RefinePoseResult result = judge(candidate);
    EXPECT_LT(result.held_out_after.log_ratio, RefinePoseOptions().min_log_ratio);
    expect_refused(result, candidate, "");
  }
}

TEST(JointVerdict, ClutterIsNoEvidence) {
  const View view = clutter();
  const JointCandidate alone = candidate_at(view, true_view(), kWellKnown, kAsCoarse);
  const RefinePoseResult result = judge(alone);
  EXPECT_GE(result.num_matches, RefinePoseOptions().min_samples);
  EXPECT_LT(result.held_out_after.log_ratio, RefinePoseOptions().min_log_ratio);
  expect_refused(result, alone, "more than by chance");
}

TEST(JointVerdict, WhereOthersPlaceTheImageItsEdgesNeedOnlyAgree) {
  // Less evidence than what convinces alone.
  RefinePoseOptions options;
  options.min_log_ratio = 1e6;
  const View view;
  const JointCandidate alone = candidate_at(view, true_view(), kWellKnown, kAsCoarse);
  expect_refused(judge(alone, options), alone, "more than by chance");
  const JointCandidate placed = candidate_at(view, true_view(), kWellKnown, 4.0 * kWellKnown);
  EXPECT_EQ(judge(placed, options).status, RefineStatus::kRefined);
}

TEST(JointVerdict, PatchesThatFitMakeUpForMissingEdgesWhereOthersPlaceTheImage) {
  const View view;
  JointCandidate candidate = candidate_at(view, true_view(), kWellKnown, kWellKnown);
  const EdgeEvidence none;
  candidate.edges = &none;
  candidate.surface_support = 19;
  expect_refused(judge(candidate), candidate, "more than by chance");
  candidate.surface_support = 20;
  EXPECT_EQ(judge(candidate).status, RefineStatus::kRefined);
  candidate.pose.from_others.covariance = kAsCoarse;
  expect_refused(judge(candidate), candidate, "too few matched edges");
}

/// Its edges lead it astray, the others know better.
JointCandidate candidate_to_place(const View& view) {
  JointCandidate candidate = candidate_at(view, disturbed(true_view(), 0.5, 0.05, 2), kWellKnown, kAsCoarse);
  candidate.pose.from_others = {true_view(), kWellKnown};
  candidate.pose.covariance_from_others = 7.0 * kWellKnown;
  return candidate;
}

TEST(JointVerdict, AnImageWhoseEdgesAreNotBelievedIsPlacedByTheOthers) {
  const View view = clutter();
  const JointCandidate candidate = candidate_to_place(view);
  RefinePoseResult result = judge(candidate);
  expect_refused(result, candidate, "more than by chance");
  ASSERT_TRUE(place_by_others(test_camera(), candidate, {}, &result));
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  EXPECT_THAT(result.reason, HasSubstr("placed by the other images"));
  EXPECT_EQ(result.camera_from_map.translation, true_view().translation);
  EXPECT_EQ(result.covariance, candidate.pose.covariance_from_others);
  JointCandidate others = candidate_at(view, true_view(), candidate.pose.covariance_from_others, kAsCoarse);
  EXPECT_NEAR(result.predicted_shift_px, judge(others).predicted_shift_px, 0.2 * result.predicted_shift_px);
  EXPECT_EQ(result.after.log_ratio, judge(others).after.log_ratio) << "of the pose that was taken";
  EXPECT_EQ(result.held_out_after.log_ratio, result.after.log_ratio) << "no edge took part";
}

TEST(JointVerdict, NothingIsPlacedByOthersThatKnowLittle) {
  const View view = clutter();
  const JointCandidate sure = candidate_to_place(view);
  const auto placed = [&](const JointCandidate& candidate, const RefinePoseOptions& options = {}) {
    RefinePoseResult result = judge(candidate);
    const bool is_placed = place_by_others(test_camera(), candidate, options, &result);
    if (!is_placed) expect_refused(result, candidate, "");
    return is_placed;
  };
  EXPECT_TRUE(placed(sure));
  JointCandidate unsure = sure;
  unsure.pose.covariance_from_others = kAsCoarse;
  EXPECT_FALSE(placed(unsure)) << "as uncertain as the way from the coarse pose";
  unsure.pose.covariance_from_others = variances(0.25, 0.025);
  EXPECT_TRUE(placed(unsure)) << "a quarter of it";
  RefinePoseOptions strict;
  strict.max_predicted_share = 0.0;
  EXPECT_FALSE(placed(unsure, strict));
  unsure.most_are_proven = false;
  EXPECT_FALSE(placed(unsure)) << "down a corridor the others know nothing";
  JointCandidate contradicted = sure;
  contradicted.surface_support = -1;
  EXPECT_FALSE(placed(contradicted)) << "its patches lie elsewhere";
}

TEST(JointVerdict, WithoutOthersItMustBeatTheCoarsePose) {
  const View view;
  const JointCandidate candidate = candidate_at(view, true_view(), kWellKnown, kAsCoarse);
  EdgeResidual before;
  before.log_ratio = judge(candidate).held_out_after.log_ratio - 1.0;
  const RefinePoseResult result = judge_joint_pose(test_camera(), candidate, before, {});
  EXPECT_EQ(result.held_out_before.log_ratio, before.log_ratio);
  expect_refused(result, candidate, "than before");
}

TEST(JointVerdict, AnImageWithoutEdgesIsRefused) {
  const View view;
  JointCandidate candidate = candidate_at(view, true_view(), kWellKnown, kAsCoarse);
  const EdgeEvidence none;
  candidate.edges = &none;
  expect_refused(judge(candidate), candidate, "too few matched edges");
  candidate.pose.from_others.covariance = kWellKnown;
  expect_refused(judge(candidate), candidate, "do not lie on image edges");
}

TEST(JointVerdict, ThePredictedShiftByHand) {
  // 2 m ahead on the optical axis of a camera of 400 px: 200 px a metre to the side, 400 px a radian about x and y,
  // and nothing along z.
  const Camera camera(CameraModel::kPinhole, 640, 480, {400, 400, 320, 240});
  const EdgeEvidence none;
  JointCandidate candidate;
  candidate.edges = &none;
  candidate.surface_in_map = {{0, 0, 2}};
  Vector6d sigmas;
  sigmas << 0.0, 0.002, 0.7, 0.003, 0.0, 0.9;
  candidate.pose.covariance = sigmas.cwiseAbs2().asDiagonal();
  candidate.pose.from_others.covariance = Matrix6d::Identity();
  const auto shift = [&] { return judge_joint_pose(camera, candidate, {}, {}).predicted_shift_px; };
  EXPECT_NEAR(shift(), std::hypot(400 * 0.002, 200 * 0.003), 1e-6);
  // Turning about y moves the point the other way than a step along x, by 2 m a radian: fully correlated they cancel.
  candidate.pose.covariance.setZero();
  const Eigen::Vector2d turn_and_step(0.002, -0.004);
  candidate.pose.covariance(1, 1) = turn_and_step.x() * turn_and_step.x();
  candidate.pose.covariance(3, 3) = turn_and_step.y() * turn_and_step.y();
  candidate.pose.covariance(1, 3) = candidate.pose.covariance(3, 1) = turn_and_step.x() * turn_and_step.y();
  EXPECT_NEAR(shift(), 0.0, 1e-6);
  // The mean over points: at 4 m a step of 3 mm is 0.3 px; points behind the camera do not count.
  sigmas << 0, 0, 0, 0.003, 0, 0;
  candidate.pose.covariance = sigmas.cwiseAbs2().asDiagonal();
  candidate.surface_in_map = {{0, 0, 2}, {0, 0, 4}, {0, 0, -2}};
  EXPECT_NEAR(shift(), 0.5 * (0.6 + 0.3), 1e-6);
}

}  // namespace
}  // namespace cpplus
