#include "cpplus/refine/refine_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cpplus/core/error.h"
#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDegree = std::numbers::pi / 180.0;

RefinePoseResult refine_from(const Rigid3& start, const ImageEdges& image, const TestRoom& room = furnished_room(),
                             const RefinePoseOptions& options = {}) {
  const Camera camera = test_camera();
  const auto samples = samples_in_view(room, camera, start);
  return refine_pose(camera, start, {start, options.prior.sigmas()}, room.edges, samples, image, options);
}

ImageEdges photograph(double textured_share, int clutter_chains) {
  DrawnNoise noise;
  noise.textured_share = textured_share;
  noise.clutter_chains = clutter_chains;
  return draw_room(furnished_room(), test_camera(), true_view(), noise);
}

double shift_px(const Rigid3& camera_from_map) {
  return mean_shift_px(furnished_room(), test_camera(), true_view(), camera_from_map);
}

void expect_recovered(const Rigid3& start, const ImageEdges& image) {
  const RefinePoseResult result = refine_from(start, image);
  EXPECT_EQ(result.status, RefineStatus::kRefined) << result.reason;
  EXPECT_THAT(result.reason, IsEmpty());
  const Vector6d error = camera_difference(true_view(), result.camera_from_map);
  EXPECT_LT(error.head<3>().norm(), 0.1 * kDegree);
  EXPECT_LT(error.tail<3>().norm(), 0.01);
  EXPECT_LT(shift_px(result.camera_from_map), 1.0) << "from " << shift_px(start);
  EXPECT_LT(result.held_out_after.rms_px, result.held_out_before.rms_px);
  EXPECT_THAT(result.weak_directions, IsEmpty());
}

void expect_unchanged(const RefinePoseResult& result, const Rigid3& start) {
  EXPECT_EQ(result.status, RefineStatus::kKeptCoarse);
  EXPECT_FALSE(result.reason.empty());
  EXPECT_EQ(result.camera_from_map.rotation.coeffs(), start.rotation.coeffs());
  EXPECT_EQ(result.camera_from_map.translation, start.translation);
}

TEST(RefinePose, RecoversOneDegreeAndTenCentimetres) {
  const ImageEdges image = photograph(0.0, 0);
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    expect_recovered(disturbed(true_view(), 1.0, 0.10, seed), image);
  }
}

TEST(RefinePose, RecoversTwoDegreesAndTwentyCentimetres) {
  const ImageEdges image = photograph(0.0, 0);
  for (uint64_t seed = 11; seed <= 16; ++seed) {
    SCOPED_TRACE(seed);
    expect_recovered(disturbed(true_view(), 2.0, 0.20, seed), image);
  }
}

TEST(RefinePose, RecoversAmongTextureBesideTheEdgesAndClutter) {
  const ImageEdges image = photograph(0.4, 80);
  for (uint64_t seed = 21; seed <= 26; ++seed) {
    SCOPED_TRACE(seed);
    expect_recovered(disturbed(true_view(), 1.0, 0.10, seed), image);
  }
}

TEST(RefinePose, StaysAtTheRightPose) {
  const RefinePoseResult result = refine_from(true_view(), photograph(0.2, 40));
  EXPECT_LT(shift_px(result.camera_from_map), 0.3);
  EXPECT_LT(shift_px(result.candidate_camera_from_map), 0.5);
}

TEST(RefinePose, FollowsThePaperWithoutASearch) {
  // The paper's own way, nearest edges from the coarse pose on: a smaller basin, 0.3 degrees and 3 cm.
  RefinePoseOptions options;
  options.search.enabled = false;
  const ImageEdges image = photograph(0.0, 0);
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Rigid3 start = disturbed(true_view(), 0.3, 0.03, seed);
    const RefinePoseResult result = refine_from(start, image, furnished_room(), options);
    EXPECT_LT(shift_px(result.candidate_camera_from_map), 0.7) << seed << ", from " << shift_px(start);
  }
}

TEST(RefinePose, AmongClutterAloneTheCoarsePoseIsKept) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    DrawnNoise noise;
    noise.room = false;
    noise.clutter_chains = 250;
    noise.seed = seed;
    const ImageEdges clutter = draw_room(furnished_room(), test_camera(), true_view(), noise);
    const Rigid3 start = disturbed(true_view(), 1.0, 0.10, seed);
    expect_unchanged(refine_from(start, clutter), start);
  }
}

TEST(RefinePose, WithoutImageEdgesTheCoarsePoseIsKept) {
  ImageEdges nothing;
  nothing.width = test_camera().width();
  nothing.height = test_camera().height();
  const Rigid3 start = disturbed(true_view(), 1.0, 0.10, 1);
  expect_unchanged(refine_from(start, nothing), start);
}

TEST(RefinePose, WithTooFewEdgesTheCoarsePoseIsKept) {
  TestRoom room = furnished_room();
  const Rigid3 start = disturbed(true_view(), 1.0, 0.10, 2);
  const auto samples = samples_in_view(room, test_camera(), start);
  // The two edges with the most samples.
  std::vector<uint32_t> order(room.edges.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::vector<size_t> counts(room.edges.size());
  for (const EdgeSample& sample : samples) ++counts[sample.edge];
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return counts[a] > counts[b]; });
  room.edges = {room.edges[order[0]], room.edges[order[1]]};
  expect_unchanged(refine_from(start, photograph(0.0, 0), room), start);

  room.edges.clear();
  const RefinePoseResult result = refine_from(start, photograph(0.0, 0), room);
  expect_unchanged(result, start);
  EXPECT_THAT(result.reason, HasSubstr("too few"));
  EXPECT_EQ(result.num_samples, 0);
}

// A wall with grooves and a bare ceiling and floor: all lines run along x, past both borders of the image.
TestRoom bare_corridor() {
  TestRoom room;
  for (const double depth : {2.0, 3.0, 4.5, 6.0}) {
    for (const double height : {-1.2, -0.7, -0.25, 0.2, 0.65, 1.1}) {
      MapEdge edge;
      edge.start = {-20, depth, height * depth / 3.0};
      edge.end = {20, depth, height * depth / 3.0};
      edge.normal_a = {0, -1, 0};
      edge.normal_b = {0, 0, 1};
      edge.inward_a = {0, 0, 1};
      edge.inward_b = {0, 1, 0};
      edge.covariance = 4e-6 * Eigen::Vector3d(0, 1, 1).asDiagonal();
      edge.group = static_cast<uint32_t>(room.edges.size());
      room.edges.push_back(edge);
    }
  }
  return room;
}

TEST(RefinePose, AlongParallelEdgesThePriorIsKept) {
  const TestRoom room = bare_corridor();
  const Rigid3 truth = look_at({0, 0, 0}, {0, 1, 0});  // camera x = map x
  DrawnNoise noise;
  const ImageEdges image = draw_room(room, test_camera(), truth, noise);
  for (const double along_m : {-0.1, 0.0, 0.08}) {
    Vector6d delta;
    delta << 0.006, 0.003, -0.006, along_m, 0.04, -0.03;
    const Rigid3 start = perturb_camera(truth, delta);
    const RefinePoseResult result = refine_from(start, image, room);
    EXPECT_THAT(result.weak_directions, Contains(HasSubstr("translation x"))) << along_m;
    EXPECT_LT(result.information_eigenvalues(0), 1.0);
    EXPECT_GT(result.information_eigenvalues(2), 1.0);
    // Nothing but the prior knows the place along the edges.
    const Vector6d change = camera_difference(start, result.candidate_camera_from_map);
    EXPECT_LT(std::abs(change(3)), 0.01) << along_m;
    const Vector6d error = camera_difference(truth, result.candidate_camera_from_map);
    EXPECT_LT(std::abs(error(0)), 0.2 * kDegree);
    EXPECT_LT(std::abs(error(2)), 0.2 * kDegree);
    EXPECT_LT(std::abs(error(4)), 0.015);
    // And its standard deviation there is nearly the prior's.
    EXPECT_GT(std::sqrt(result.covariance(3, 3)), 0.7 * RefinePoseOptions().prior.translation_sigma_m);
  }
}

TEST(RefinePose, TheCovarianceIsOfTheErrorsSize) {
  // Errors as the noise model has them: each edgel and each edge in the image, each edge in the map. The normalised
  // squared error has mean 6 where the covariance is right; larger where it is overconfident.
  RefinePoseOptions options;
  double sum = 0.0;
  int count = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    DrawnNoise noise;
    noise.edge_sigma_px = options.edge_sigma_px;
    noise.seed = seed;
    const ImageEdges image = draw_room(furnished_room(), test_camera(), true_view(), noise);
    TestRoom measured = furnished_room();
    Random random(1000 + seed);
    for (MapEdge& edge : measured.edges) {
      const Eigen::Vector3d shift = edge.covariance.diagonal().cwiseSqrt().cwiseProduct(
          Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
      edge.start += shift;
      edge.end += shift;
    }
    const Rigid3 start = disturbed(true_view(), 1.0, 0.10, seed);
    const RefinePoseResult result = refine_from(start, image, measured, options);
    if (result.status != RefineStatus::kRefined) continue;
    const Vector6d error = camera_difference(result.camera_from_map, true_view());
    sum += error.dot(result.covariance.ldlt().solve(error));
    ++count;
  }
  ASSERT_GE(count, 36);
  RecordProperty("mean_normalised_squared_error", std::to_string(sum / count));
  std::cout << "mean normalised squared error over " << count << " images: " << sum / count << "\n";
  EXPECT_GT(sum / count, 1.0);
  EXPECT_LT(sum / count, 20.0);
}

TEST(RefinePose, TheCovarianceIsSymmetricPositiveAndBelowThePrior) {
  const RefinePoseResult result = refine_from(disturbed(true_view(), 0.5, 0.05, 5), photograph(0.0, 0));
  EXPECT_LT((result.covariance - result.covariance.transpose()).norm(), 1e-12 * result.covariance.norm());
  EXPECT_EQ(Eigen::LLT<Matrix6d>(result.covariance).info(), Eigen::Success);
  const Vector6d sigmas = RefinePoseOptions().prior.sigmas();
  for (int i = 0; i < 6; ++i) EXPECT_LT(result.covariance(i, i), sigmas(i) * sigmas(i));
  EXPECT_TRUE(std::is_sorted(result.information_eigenvalues.begin(), result.information_eigenvalues.end()));
}

TEST(RefinePose, TheSameInputGivesTheSameBits) {
  const Rigid3 start = disturbed(true_view(), 1.0, 0.10, 4);
  const ImageEdges image = photograph(0.3, 60);
  const RefinePoseResult a = refine_from(start, image);
  const RefinePoseResult b = refine_from(start, image);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.camera_from_map.rotation.coeffs(), b.camera_from_map.rotation.coeffs());
  EXPECT_EQ(a.camera_from_map.translation, b.camera_from_map.translation);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(RefinePose, FiguresCountWhatTheyName) {
  const Rigid3 start = disturbed(true_view(), 1.0, 0.10, 4);
  const RefinePoseResult result = refine_from(start, photograph(0.0, 0));
  EXPECT_GT(result.num_edges, RefinePoseOptions().min_edges);
  EXPECT_LE(result.num_matches, result.num_samples);
  EXPECT_GT(result.iterations, 0);
  EXPECT_GT(result.held_out_before.num_samples, 0);
  EXPECT_LE(result.after.num_matches, result.after.num_samples);
  EXPECT_LT(result.after.median_px, result.before.median_px);
  EXPECT_GT(result.after.inlier_share, 0.7);
  EXPECT_LE(result.after.inlier_share, 1.0);
}

TEST(RefinePoseOptions, ValuesOutOfRangeAreNamed) {
  const auto message = [](const RefinePoseOptions& options) {
    try {
      options.validate();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  RefinePoseOptions options;
  EXPECT_EQ(message(options), "");
  options.max_angle_deg = 90.0;
  EXPECT_THAT(message(options), HasSubstr("max_angle_deg"));
  options = {};
  options.prior.rotation_sigma_deg = 0.0;
  EXPECT_THAT(message(options), HasSubstr("rotation_sigma_deg"));
  options = {};
  options.search.poses_per_round = 1;
  EXPECT_THAT(message(options), HasSubstr("poses_per_round"));
  options = {};
  options.folds = 1;
  EXPECT_THAT(message(options), HasSubstr("folds"));
}

}  // namespace
}  // namespace cpplus
