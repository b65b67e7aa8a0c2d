#include "cpplus/refine/edge_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "cpplus/refine/edge_likelihood.h"
#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

constexpr double kRadius = 24.0;
constexpr double kAngle = 15.0;

Camera pinhole() { return Camera(CameraModel::kPinhole, 640, 480, {400, 400, 320, 240}); }

// A vertical edge 2 m ahead with one sample, seen at (320, 240).
std::vector<MapEdge> vertical_edge() {
  MapEdge edge;
  edge.start = {0, -1, 2};
  edge.end = {0, 1, 2};
  edge.covariance = 1e-6 * Eigen::Vector3d(1, 0, 1).asDiagonal();
  return {edge};
}

std::vector<EdgeSample> one_sample() { return {{{0, 0, 2}, {0, 1, 0}, 0, 1}}; }

ImageEdges edgels_at(const std::vector<Eigen::Vector2f>& pixels, const Eigen::Vector2f& normal = {1, 0}) {
  ImageEdges edges;
  edges.width = 640;
  edges.height = 480;
  for (const Eigen::Vector2f& pixel : pixels) edges.edgels.push_back({pixel, normal, 20.0f});
  return edges;
}

EdgeEvidence evidence_of(const ImageEdges& edges) {
  return EdgeEvidence(pinhole(), Rigid3(), vertical_edge(), one_sample(), edges, kRadius, kAngle);
}

// The edge is seen so many pixels to the right of (320, 240).
Rigid3 seen_right_by(double pixels) {
  return Rigid3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(pixels / 200.0, 0, 0));
}

std::vector<EdgeMatch> match(const EdgeEvidence& evidence, const Rigid3& pose, double radius_px = 8.0) {
  return evidence.match(pinhole(), pose, radius_px, {}, evidence.all());
}

TEST(EdgeEvidence, MatchesTheNearestAcrossTheEdgeFromWhereItIsSeen) {
  const EdgeEvidence evidence = evidence_of(edgels_at({{323.0f, 240.0f}, {314.0f, 240.0f}}));
  ASSERT_EQ(evidence.num_samples(), 1u);
  const std::vector<EdgeMatch> right = match(evidence, Rigid3());
  ASSERT_EQ(right.size(), 1u);
  EXPECT_EQ(right[0].pixel, Eigen::Vector2d(323, 240));
  EXPECT_NEAR(right[0].projected.pixel.x(), 320.0, 1e-9);
  EXPECT_NEAR(std::abs(right[0].normal.x()), 1.0, 1e-9);
  const std::vector<EdgeMatch> left = match(evidence, seen_right_by(-3.0));
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].pixel, Eigen::Vector2d(314, 240));
  EXPECT_NEAR(evidence.distances(pinhole(), seen_right_by(-3.0), 8.0, evidence.all()).at(0), 3.0, 1e-6);
}

TEST(EdgeEvidence, NothingBeyondTheRadius) {
  const EdgeEvidence evidence = evidence_of(edgels_at({{323.0f, 240.0f}, {350.0f, 240.0f}}));
  EXPECT_TRUE(match(evidence, Rigid3(), 2.9).empty());
  EXPECT_EQ(evidence.distances(pinhole(), Rigid3(), 2.9, evidence.all()), std::vector<double>{2.9});
  // The edgel at 350 was out of reach from the reference pose.
  EXPECT_TRUE(match(evidence, seen_right_by(30.0)).empty());
}

TEST(EdgeEvidence, EdgelsOfAnotherDirectionAreNoCandidates) {
  EXPECT_TRUE(match(evidence_of(edgels_at({{322.0f, 240.0f}}, {0, 1})), Rigid3()).empty());
  EXPECT_EQ(match(evidence_of(edgels_at({{322.0f, 240.0f}}, {-1, 0})), Rigid3()).size(), 1u);
  EXPECT_TRUE(match(evidence_of(edgels_at({})), Rigid3()).empty());
}

TEST(EdgeEvidence, EachCrossingGivesTheEdgelOnTheLine) {
  // The edgels above and below are nearer across the edge, but belong to the same crossing.
  const EdgeEvidence evidence = evidence_of(edgels_at({{323.0f, 239.0f}, {323.6f, 240.0f}, {323.2f, 241.0f}}));
  const std::vector<EdgeMatch> matches = match(evidence, Rigid3());
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].pixel.cast<float>(), Eigen::Vector2f(323.6f, 240.0f));
}

TEST(EdgeEvidence, NoiseIsWeighedAsForSingleImages) {
  const EdgeEvidence evidence = evidence_of(edgels_at({{323.0f, 240.0f}}));
  const EdgeMatch m = evidence.match(pinhole(), Rigid3(), 8.0, {0.3, 0.4}, evidence.all()).at(0);
  // 200 px a metre make 1 mm of the map edge 0.2 px; across it the camera's own 0.3 px and 0.4 px in common.
  EXPECT_NEAR(m.sigma_px, std::sqrt(0.09 + 0.16 + 0.04), 1e-6);
  EXPECT_NEAR(m.weight, 1.0, 1e-9);
}

TEST(EdgeEvidence, SamplesBehindTheCameraAreLeftOut) {
  std::vector<EdgeSample> samples = one_sample();
  samples.push_back({{0, 0, -2}, {0, 1, 0}, 0, 1});
  const EdgeEvidence evidence(pinhole(), Rigid3(), vertical_edge(), samples, edgels_at({}), kRadius, kAngle);
  EXPECT_EQ(evidence.num_samples(), 1u);
  EXPECT_EQ(EdgeEvidence().num_samples(), 0u);
  EXPECT_EQ(EdgeEvidence().log_ratio(pinhole(), Rigid3(), 2.5, {}), 0.0);
}

struct RoomEvidence {
  TestRoom room = furnished_room();
  std::vector<EdgeSample> samples;
  ImageEdges image;
  EdgeEvidence evidence;

  explicit RoomEvidence(const DrawnNoise& noise = {}) {
    const Camera camera = test_camera();
    samples = samples_in_view(room, camera, true_view());
    image = draw_room(room, camera, true_view(), noise);
    evidence = EdgeEvidence(camera, true_view(), room.edges, samples, image, kRadius, kAngle);
  }
};

TEST(EdgeEvidence, FoldsHoldEverySampleOnceAndKeepGroupsTogether) {
  RoomEvidence r;
  for (MapEdge& edge : r.room.edges) edge.group /= 2;  // two edges a group
  const EdgeEvidence evidence(test_camera(), true_view(), r.room.edges, r.samples, r.image, kRadius, kAngle);
  ASSERT_EQ(evidence.num_samples(), r.samples.size());
  const std::vector<EdgeEvidence::Selection> folds = evidence.folds(4);
  ASSERT_EQ(folds.size(), 4u);
  std::set<uint32_t> seen;
  std::map<uint32_t, std::set<size_t>> folds_of_group;
  for (size_t fold = 0; fold < folds.size(); ++fold) {
    EXPECT_GT(folds[fold].size(), r.samples.size() / 10);
    for (const uint32_t i : folds[fold]) {
      EXPECT_TRUE(seen.insert(i).second);
      folds_of_group[r.room.edges[r.samples[i].edge].group].insert(fold);
    }
  }
  EXPECT_EQ(seen.size(), r.samples.size());
  EXPECT_GT(folds_of_group.size(), 8u);
  for (const auto& [group, its_folds] : folds_of_group) EXPECT_EQ(its_folds.size(), 1u) << group;
}

TEST(EdgeEvidence, TheTruePoseExplainsTheImageBest) {
  const RoomEvidence r;
  const auto at = [&](const Rigid3& pose) { return r.evidence.log_ratio(test_camera(), pose, 2.5, r.evidence.all()); };
  const double truth = at(true_view());
  EXPECT_GT(truth, 30.0);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const double near = at(disturbed(true_view(), 0.5, 0.03, seed));
    const double far = at(disturbed(true_view(), 2.0, 0.15, seed));
    EXPECT_LT(near, truth) << seed;
    EXPECT_LT(far, 0.5 * truth) << seed;
  }
}

TEST(EdgeEvidence, AgreesWithTheLikelihoodOfSingleImages) {
  // That one looks distances up in a field of cells, for directions in bins.
  const RoomEvidence r;
  const DirectionalDistanceField field(r.image, 2, 40.0);
  for (uint64_t seed = 0; seed <= 5; ++seed) {
    const Rigid3 pose = disturbed(true_view(), 0.3 * static_cast<double>(seed), 0.03 * static_cast<double>(seed), seed);
    EdgeLikelihood likelihood(test_camera(), pose, r.room.edges, r.samples, field, 100000);
    likelihood.set_kernel(2.5);
    const double expected = likelihood.log_ratio_fitted();
    const double found = r.evidence.log_ratio(test_camera(), pose, 2.5, r.evidence.all());
    EXPECT_NEAR(found, expected, 0.3 * expected + 10.0) << seed;
  }
}

TEST(EdgeEvidence, ClutterIsNoEvidence) {
  DrawnNoise clutter;
  clutter.room = false;
  clutter.clutter_chains = 150;
  const RoomEvidence r(clutter);
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Rigid3 pose = disturbed(true_view(), 1.0, 0.1, seed);
    EXPECT_LT(r.evidence.log_ratio(test_camera(), pose, 2.5, r.evidence.all()), 10.0) << seed;
  }
}

TEST(EdgeEvidence, ASelectionIsLookedAtAlone) {
  const RoomEvidence r;
  const std::vector<EdgeEvidence::Selection> folds = r.evidence.folds(2);
  const auto count = [&](const EdgeEvidence::Selection& selection) {
    return r.evidence.match(test_camera(), true_view(), 3.0, {}, selection).size();
  };
  EXPECT_GT(count(folds[0]), 0u);
  EXPECT_EQ(count(folds[0]) + count(folds[1]), count(r.evidence.all()));
  EXPECT_EQ(r.evidence.distances(test_camera(), true_view(), 3.0, folds[0]).size(), folds[0].size());
}

}  // namespace
}  // namespace cpplus
