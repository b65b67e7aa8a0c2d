#include "cpplus/refine/pose_search.h"

#include <gtest/gtest.h>

#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

struct Found {
  PoseSearchResult result;
  double start_shift_px = 0.0;
  double shift_px = 0.0;
};

Found search_from(const Rigid3& start, const DrawnNoise& noise) {
  const TestRoom room = furnished_room();
  const Camera camera = test_camera();
  const ImageEdges image = draw_room(room, camera, true_view(), noise);
  const auto samples = samples_in_view(room, camera, start);
  const PoseSearchOptions options;
  const DirectionalDistanceField field(image, 4, 3.0 * options.first_kernel_px);
  Found found;
  found.result = search_pose(camera, {start, PosePrior().sigmas()}, room.edges, samples, field, options);
  found.start_shift_px = mean_shift_px(room, camera, true_view(), start);
  found.shift_px = mean_shift_px(room, camera, true_view(), found.result.camera_from_map);
  return found;
}

DrawnNoise texture_and_clutter() {
  DrawnNoise noise;
  noise.textured_share = 0.4;
  noise.clutter_chains = 100;
  return noise;
}

TEST(SearchPose, EndsWithinReachOfMatchingAlsoAmongTextureAndClutter) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const Found found = search_from(disturbed(true_view(), 2.0, 0.20, seed), texture_and_clutter());
    EXPECT_GT(found.start_shift_px, 10.0) << seed;
    EXPECT_LT(found.shift_px, 4.0) << seed << ", from " << found.start_shift_px;
    EXPECT_GT(found.result.best_score, found.result.start_score) << seed;
  }
}

TEST(SearchPose, DoesNotLeaveTheRightPose) { EXPECT_LT(search_from(true_view(), texture_and_clutter()).shift_px, 3.0); }

TEST(SearchPose, TheSameInputGivesTheSameBits) {
  const Rigid3 start = disturbed(true_view(), 1.0, 0.1, 3);
  const Rigid3 a = search_from(start, texture_and_clutter()).result.camera_from_map;
  const Rigid3 b = search_from(start, texture_and_clutter()).result.camera_from_map;
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  EXPECT_EQ(a.translation, b.translation);
}

TEST(SearchPose, WithoutSamplesTheStartStays) {
  const Camera camera = test_camera();
  const DirectionalDistanceField field(draw_room(furnished_room(), camera, true_view(), {}), 4, 24.0);
  const PoseSearchResult result = search_pose(camera, {true_view(), PosePrior().sigmas()}, {}, {}, field, {});
  EXPECT_EQ(result.camera_from_map.translation, true_view().translation);
}

TEST(PosePrior, SigmasAreInRadiansAndMetres) {
  PosePrior prior;
  prior.rotation_sigma_deg = 180.0;
  prior.translation_sigma_m = 0.3;
  Vector6d expected;
  expected << Eigen::Vector3d::Constant(std::numbers::pi), Eigen::Vector3d::Constant(0.3);
  EXPECT_LT((prior.sigmas() - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace cpplus
