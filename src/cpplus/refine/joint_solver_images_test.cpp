// The joint solve over what images show: patches of planes that they share, and edges.

#include <gtest/gtest.h>

#include "cpplus/core/parallel.h"
#include "cpplus/refine/joint_solver.h"
#include "cpplus/refine/pose_search.h"
#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

const Vector6d kPrior = PosePrior().sigmas();
constexpr double kDegree = std::numbers::pi / 180.0;

// Views of the furnished room from nearby places.
std::vector<Rigid3> true_views() {
  return {true_view(), look_at({1.3, 0.7, 1.5}, {4.3, 3.9, 1.1}), look_at({0.8, 1.3, 1.7}, {4.5, 3.5, 1.2}),
          look_at({1.5, 1.0, 1.4}, {4.2, 3.6, 1.3})};
}

struct MatchNoise {
  double own_px = 0.3;
  double plane_px = 0.3;
};

/// Spots on a grid in image a as image b shows them.
std::vector<SurfaceMatch> draw_matches(const TestRoom& room, const std::vector<Rigid3>& views, uint32_t a, uint32_t b,
                                       const MatchNoise& noise, Random* random) {
  const Camera camera = test_camera();
  const PlaneBuffer planes = cast_plane_buffer(room, camera, views[a], 8.0);
  std::map<int32_t, Eigen::Vector2d> shift_of_plane;
  std::vector<SurfaceMatch> matches;
  for (double y = 20; y < camera.height(); y += 40) {
    for (double x = 20; x < camera.width(); x += 40) {
      SurfaceMatch m;
      m.image_a = a;
      m.image_b = b;
      m.pixel_a = {x, y};
      m.plane = planes.plane_at(m.pixel_a);
      if (m.plane == PlaneBuffer::kNone) continue;
      const MapPlane& plane = room.planes[static_cast<size_t>(m.plane)];
      m.point_in_map = plane.centroid;
      m.normal_in_map = plane.normal;
      const Eigen::Vector3d spot =
          inverse(views[a]) * Eigen::Vector3d(planes.range_of(plane, m.pixel_a) * *camera.unproject(m.pixel_a));
      const auto pixel = camera.project(views[b] * spot);
      if (!pixel || !camera.in_image(*pixel) || !truly_visible(room, camera_center(views[b]), spot)) continue;
      const Eigen::Vector2d drawn_shift(random->normal(), random->normal());
      const auto [shift, is_new] = shift_of_plane.try_emplace(m.plane, noise.plane_px * drawn_shift);
      m.pixel_b = *pixel + shift->second + noise.own_px * Eigen::Vector2d(random->normal(), random->normal());
      matches.push_back(m);
    }
  }
  return matches;
}

/// The room, what the images show of it, and a problem that starts at coarse poses.
struct Photographs {
  TestRoom room = furnished_room();
  Camera camera = test_camera();
  std::vector<Rigid3> truth = true_views();
  std::vector<EdgeEvidence> edges;
  JointProblem problem;

  explicit Photographs(const std::vector<Rigid3>& coarse) : edges(coarse.size()) {
    for (size_t i = 0; i < coarse.size(); ++i) {
      JointImage image;
      image.camera = &camera;
      image.camera_id = 1;
      image.coarse_camera_from_map = image.camera_from_map = coarse[i];
      problem.images.push_back(image);
      problem.sequences[1].emplace_back(static_cast<double>(i), i);
    }
  }
  Photographs(const Photographs&) = delete;  // the problem points into it

  void draw_edges(const DrawnNoise& noise) {
    for (size_t i = 0; i < edges.size(); ++i) draw_edges_of(i, room, noise);
  }

  // `drawn` may differ from the room as the map knows it.
  void draw_edges_of(size_t i, const TestRoom& drawn, DrawnNoise noise) {
    noise.seed = 10 * noise.seed + i;
    const Rigid3& coarse = problem.images[i].coarse_camera_from_map;
    const auto samples = samples_in_view(room, camera, coarse);
    edges[i] = EdgeEvidence(camera, coarse, room.edges, samples, draw_room(drawn, camera, truth[i], noise), 24.0, 15.0);
    problem.images[i].edges = &edges[i];
  }

  void draw_surface_matches(const MatchNoise& noise, uint64_t seed = 1) {
    Random random(seed);
    for (uint32_t a = 0; a < truth.size(); ++a) {
      for (uint32_t b = 0; b < truth.size(); ++b) {
        if (a == b) continue;
        const std::vector<SurfaceMatch> more = draw_matches(room, truth, a, b, noise, &random);
        problem.matches.insert(problem.matches.end(), more.begin(), more.end());
      }
    }
  }

  JointResult solve(const JointOptions& options = {}) const { return solve_joint(problem, kPrior, {}, options); }
  double shift_px(size_t i, const Rigid3& pose) const { return mean_shift_px(room, camera, truth[i], pose); }
};

std::vector<Rigid3> disturbed_views(double angle_deg, double distance_m, uint64_t seed) {
  std::vector<Rigid3> views = true_views();
  for (size_t i = 0; i < views.size(); ++i) views[i] = disturbed(views[i], angle_deg, distance_m, 100 * seed + i);
  return views;
}

// Perturbation by which b is wrong as seen from a.
Vector6d relative_error(const Rigid3& true_a, const Rigid3& true_b, const Rigid3& a, const Rigid3& b) {
  return camera_difference(true_b * inverse(true_a), b * inverse(a));
}

TEST(SolveJointSurfaces, RelativePosesAreRecoveredFromPatchesOfPlanes) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    Photographs photos(disturbed_views(1.0, 0.10, seed));
    photos.draw_surface_matches({}, seed);
    const JointResult result = photos.solve();
    for (size_t b = 1; b < 4; ++b) {
      const Vector6d error = relative_error(photos.truth[0], photos.truth[b], result.poses[0].camera_from_map,
                                            result.poses[b].camera_from_map);
      EXPECT_LT(error.head<3>().norm(), 0.1 * kDegree);
      EXPECT_LT(error.tail<3>().norm(), 0.01);
    }
  }
}

TEST(SolveJointSurfaces, OneImageThatKnowsItsPosePlacesTheOthers) {
  Photographs photos(disturbed_views(1.0, 0.10, 4));
  photos.draw_surface_matches({});
  photos.problem.images[2].observed =
      PoseObservation{photos.truth[2], Matrix6d((0.01 * kPrior).cwiseAbs2().cwiseInverse().asDiagonal())};
  const JointResult result = photos.solve();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT(photos.shift_px(i, result.poses[i].camera_from_map), 1.0) << i;
    EXPECT_GT(photos.shift_px(i, photos.problem.images[i].coarse_camera_from_map), 5.0) << i;
  }
  EXPECT_LT(photos.shift_px(0, result.poses[0].from_others.camera_from_map), 1.0);
}

// The map has its surface nearer than the images show it, along the rays of the image that a patch is from.
TEST(SolveJointSurfaces, TheScaleOfTheMapsRangesIsFound) {
  for (const double scale : {0.0, 0.006, -0.006}) {
    SCOPED_TRACE(scale);
    Photographs photos(disturbed_views(0.3, 0.03, 4));
    photos.draw_surface_matches({0.1, 0.0});
    for (size_t i = 0; i < 4; ++i) {
      photos.problem.images[i].observed =
          PoseObservation{photos.truth[i], Matrix6d((0.01 * kPrior).cwiseAbs2().cwiseInverse().asDiagonal())};
    }
    for (SurfaceMatch& m : photos.problem.matches) {
      const Eigen::Vector3d center = camera_center(photos.truth[m.image_a]);
      m.point_in_map = center + (m.point_in_map - center) / (1.0 + scale);
    }
    const JointResult result = photos.solve();
    const auto& found = result.shared.at(1).range_scale;
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, scale, 0.0015);
    EXPECT_EQ(found->value, result.range_scale);
    EXPECT_LT(std::abs(found->value - scale), 2 * found->sigma);
    EXPECT_LT(found->sigma, 0.002);

    JointOptions held;
    held.range_scale_sigma = 0.0;
    const JointResult without = photos.solve(held);
    EXPECT_FALSE(without.shared.at(1).range_scale);
    EXPECT_EQ(without.range_scale, 0.0);
    double mean = 0.0, mean_without = 0.0;
    for (size_t i = 0; i < 4; ++i) {
      mean += 0.25 * photos.shift_px(i, result.poses[i].camera_from_map);
      mean_without += 0.25 * photos.shift_px(i, without.poses[i].camera_from_map);
    }
    EXPECT_LT(mean, 0.15);
    if (scale != 0.0) {
      EXPECT_GT(mean_without, 2.0 * mean);
    }
  }
}

TEST(SolveJointSurfaces, WithoutPatchesThereIsNoRangeScale) {
  Photographs photos(disturbed_views(0.3, 0.03, 4));
  photos.draw_edges({});
  EXPECT_FALSE(photos.solve().shared.at(1).range_scale);
}

TEST(SolveJointSurfaces, AFifthOfWrongMatchesDoesNotMatter) {
  Photographs photos(disturbed_views(0.3, 0.03, 5));
  photos.draw_surface_matches({});
  Random random(1);
  for (SurfaceMatch& m : photos.problem.matches) {
    if (random.uniform() < 0.2) m.pixel_b += Eigen::Vector2d(random.uniform(-40, 40), random.uniform(-40, 40));
  }
  const JointResult result = photos.solve();
  for (size_t b = 1; b < 4; ++b) {
    const Vector6d error = relative_error(photos.truth[0], photos.truth[b], result.poses[0].camera_from_map,
                                          result.poses[b].camera_from_map);
    EXPECT_LT(error.head<3>().norm(), 0.15 * kDegree);
    EXPECT_LT(error.tail<3>().norm(), 0.015);
  }
}

/// Where the images show spots of the surfaces, on a grid of pixels; every `wrong_one_in`-th somewhere near.
std::vector<std::vector<IntensityMatch>> draw_intensity_matches(const Photographs& photos, int wrong_one_in,
                                                                uint64_t seed) {
  Random random(seed);
  std::vector<std::vector<IntensityMatch>> matches(photos.truth.size());
  int count = 0;
  for (size_t i = 0; i < photos.truth.size(); ++i) {
    const PlaneBuffer planes = cast_plane_buffer(photos.room, photos.camera, photos.truth[i], 8.0);
    for (double y = 30; y < photos.camera.height(); y += 60) {
      for (double x = 30; x < photos.camera.width(); x += 60) {
        const Eigen::Vector2d pixel(x, y);
        const int32_t id = planes.plane_at(pixel);
        if (id == PlaneBuffer::kNone) continue;
        const double range = planes.range_of(photos.room.planes[static_cast<size_t>(id)], pixel);
        IntensityMatch m;
        m.x_in_map = inverse(photos.truth[i]) * Eigen::Vector3d(range * *photos.camera.unproject(pixel));
        const double off_px = ++count % wrong_one_in == 0 ? 8.0 : 0.5;
        m.pixel = pixel + off_px * Eigen::Vector2d(random.normal(), random.normal());
        m.information = 4.0 * Eigen::Matrix2d::Identity();
        matches[i].push_back(m);
      }
    }
  }
  return matches;
}

TEST(SolveJointIntensities, PosesAreFoundFromIntensitiesAloneThoughAFifthIsWrong) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    Photographs photos(disturbed_views(0.2, 0.02, seed));
    const std::vector<std::vector<IntensityMatch>> matches = draw_intensity_matches(photos, 5, seed);
    for (size_t i = 0; i < matches.size(); ++i) {
      ASSERT_GT(matches[i].size(), 15u);
      photos.problem.images[i].intensities = &matches[i];
    }
    const JointResult result = photos.solve();
    for (size_t i = 0; i < matches.size(); ++i) {
      const Rigid3& pose = result.poses[i].camera_from_map;
      EXPECT_LT(photos.shift_px(i, pose), 0.5) << i;
      EXPECT_GT(photos.shift_px(i, photos.problem.images[i].coarse_camera_from_map), 1.0) << i;
      const Vector6d error = camera_difference(photos.truth[i], pose);
      EXPECT_LT(error.dot(result.poses[i].covariance.inverse() * error), 12.6) << i;
    }
  }
}

TEST(SolveJointEdges, PosesAreFoundFromEdgesAlone) {
  Photographs photos(disturbed_views(0.4, 0.04, 6));
  photos.draw_edges({});
  const JointResult result = photos.solve();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT(photos.shift_px(i, result.poses[i].camera_from_map), 0.5) << i;
  }
}

TEST(SolveJointEdges, AnImageWithoutEdgesIsPlacedByPatches) {
  Photographs photos(disturbed_views(0.4, 0.04, 7));
  photos.draw_edges({});
  photos.draw_surface_matches({});
  photos.problem.images[1].edges = nullptr;
  const JointResult result = photos.solve();
  for (size_t i = 0; i < 4; ++i) EXPECT_LT(photos.shift_px(i, result.poses[i].camera_from_map), 0.7) << i;
  EXPECT_LT(photos.shift_px(1, result.poses[1].from_others.camera_from_map), 0.7);
}

TEST(SolveJointEdges, OneThreadAndFourGiveTheSameBits) {
  Photographs photos(disturbed_views(0.5, 0.05, 8));
  photos.draw_edges({});
  photos.draw_surface_matches({});
  set_num_threads(1);
  const JointResult one = photos.solve();
  set_num_threads(4);
  const JointResult four = photos.solve();
  set_num_threads(0);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(one.poses[i].camera_from_map.translation, four.poses[i].camera_from_map.translation);
    EXPECT_EQ(one.poses[i].camera_from_map.rotation.coeffs(), four.poses[i].camera_from_map.rotation.coeffs());
    EXPECT_EQ(one.poses[i].covariance, four.poses[i].covariance);
    EXPECT_EQ(one.poses[i].from_others.covariance, four.poses[i].from_others.covariance);
  }
  EXPECT_EQ(one.shared.at(1).extrinsic, four.shared.at(1).extrinsic);
}

TEST(SolveJointSurfaces, ImagesInNoSequenceKeepTheirPoseAndMoveNone) {
  Photographs with(disturbed_views(0.5, 0.05, 9)), without(disturbed_views(0.5, 0.05, 9));
  for (Photographs* photos : {&with, &without}) {
    photos->draw_surface_matches({});
    photos->problem.sequences[1].erase(photos->problem.sequences[1].begin() + 1);
  }
  std::erase_if(without.problem.matches, [](const SurfaceMatch& m) { return m.image_a == 1 || m.image_b == 1; });
  const JointResult x = with.solve(), y = without.solve();
  EXPECT_EQ(x.poses[1].camera_from_map.translation, with.problem.images[1].camera_from_map.translation);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(x.poses[i].camera_from_map.translation, y.poses[i].camera_from_map.translation) << i;
  }
}

// Squared errors in units of the covariance have mean 6 where it is right, more where it is overconfident. The map is
// drawn without the errors that its edges' covariances state, so that fewer are right.
TEST(SolveJointEdges, TheCovarianceIsThatOfTheErrors) {
  constexpr int kDrawings = 6;
  JointOptions options;
  options.covariance_inflation = 1.0;  // the edges have nothing in common
  double sum = 0.0;
  for (uint64_t drawing = 1; drawing <= kDrawings; ++drawing) {
    Photographs photos(disturbed_views(0.2, 0.02, drawing));
    DrawnNoise noise;
    noise.edge_sigma_px = JointEdgeOptions().noise.edge_sigma_px;
    noise.seed = drawing;
    photos.draw_edges(noise);
    photos.draw_surface_matches({}, drawing);
    const JointResult result = photos.solve(options);
    for (size_t i = 0; i < 4; ++i) {
      const PoseGuess solved{result.poses[i].camera_from_map, result.poses[i].covariance};
      sum += solved.squared_distance(photos.truth[i]) / (4 * kDrawings);
    }
  }
  EXPECT_GT(sum, 2.0);
  EXPECT_LT(sum, 8.0);
}

}  // namespace
}  // namespace cpplus
