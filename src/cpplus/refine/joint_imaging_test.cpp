// What all images of a camera share and their pixels depend on directly: the readout time of a rolling shutter and the
// intrinsics.

#include <gtest/gtest.h>

#include "cpplus/refine/joint_solver.h"
#include "cpplus/refine/pose_search.h"
#include "cpplus/refine/surface_match_residual.h"
#include "cpplus/refine/test_room.h"

namespace cpplus {
namespace {

const Vector6d kPrior = PosePrior().sigmas();

Vector6d velocity(double rx, double ry, double rz, double tx, double ty, double tz) {
  Vector6d v;
  v << rx, ry, rz, tx, ty, tz;
  return v;
}

// Four views of the furnished room by a camera that turns and walks.
struct MovingCamera {
  TestRoom room = furnished_room();
  Camera true_camera = test_camera();
  Camera given_camera = test_camera();
  std::vector<Rigid3> truth = {true_view(), look_at({1.3, 0.7, 1.5}, {4.3, 3.9, 1.1}),
                               look_at({0.8, 1.3, 1.7}, {4.5, 3.5, 1.2}), look_at({1.5, 1.0, 1.4}, {4.2, 3.6, 1.3})};
  std::vector<Vector6d> velocities = {velocity(0.2, 1.0, -0.3, 0.8, 0.1, 0.2), velocity(-0.7, -0.8, 0.4, 0.5, 0.0, 0.6),
                                      velocity(0.9, 0.3, 0.6, -0.7, 0.2, 0.0),
                                      velocity(-0.2, -1.1, -0.5, 0.0, 0.1, 1.0)};
  std::vector<EdgeEvidence> edges = std::vector<EdgeEvidence>(4);

  JointResult solve(double readout_s, const JointOptions& options) {
    JointProblem problem;
    for (size_t i = 0; i < truth.size(); ++i) {
      JointImage image;
      image.camera = &given_camera;
      image.camera_id = 1;
      image.coarse_camera_from_map = image.camera_from_map = disturbed(truth[i], 0.2, 0.02, i);
      image.velocity_per_s = velocities[i];
      DrawnNoise noise;
      noise.seed = i + 1;
      const auto samples = samples_in_view(room, given_camera, image.camera_from_map);
      const ImageEdges drawn = draw_room(room, true_camera, {truth[i], readout_s * velocities[i]}, noise);
      edges[i] = EdgeEvidence(given_camera, image.camera_from_map, room.edges, samples, drawn, 24.0, 15.0);
      image.edges = &edges[i];
      problem.images.push_back(image);
      problem.sequences[1].emplace_back(static_cast<double>(i), i);
    }
    return solve_joint(problem, kPrior, {}, options);
  }

  double worst_shift_px(const JointResult& result) const {
    double worst = 0.0;
    for (size_t i = 0; i < truth.size(); ++i) {
      worst = std::max(worst, mean_shift_px(room, true_camera, truth[i], result.poses[i].camera_from_map));
    }
    return worst;
  }
};

JointOptions with_global_shutter() {
  JointOptions options;
  options.imaging.readout_sigma_s = 0.0;
  return options;
}

JointOptions with_readout() {
  JointOptions options;
  options.imaging.readout_sigma_s = 0.02;
  return options;
}

JointOptions with_intrinsics() {
  JointOptions options = with_global_shutter();
  options.imaging.intrinsics = true;
  return options;
}

TEST(ImagePose, RowsLieBetweenTheFirstAndTheLast) {
  EXPECT_EQ(row_fraction(0.0, 481), -0.5);
  EXPECT_EQ(row_fraction(240.0, 481), 0.0);
  EXPECT_EQ(row_fraction(480.0, 481), 0.5);
  EXPECT_EQ(row_fraction(0.0, 1), 0.0);
  const Vector6d motion = velocity(0.1, 0, 0, 0, 0, 0.4);
  const ImagePose pose(true_view(), motion);
  EXPECT_TRUE(pose.moves());
  EXPECT_LT((camera_difference(true_view(), pose.at(0.5)) - 0.5 * motion).norm(), 1e-12);
  EXPECT_FALSE(ImagePose(true_view()).moves());
}

TEST(Imaging, ParametersAreTheReadoutAndThenTheIntrinsics) {
  ImagingOptions options;
  options.readout_sigma_s = 0.0;
  EXPECT_EQ(Imaging(test_camera(), true, options).num_parameters(), 0);
  options.readout_sigma_s = 0.01;
  EXPECT_EQ(Imaging(test_camera(), false, options).num_parameters(), 0);
  EXPECT_EQ(Imaging(test_camera(), true, options).num_parameters(), 1);
  options.intrinsics = true;
  Imaging imaging(test_camera(), true, options);
  ASSERT_EQ(imaging.num_parameters(), 9);
  EXPECT_EQ(imaging.num_intrinsics(), 8);
  EXPECT_DOUBLE_EQ(imaging.prior_sigmas()(1), 3.30);  // 1 % of fx = 330
  EXPECT_DOUBLE_EQ(imaging.prior_sigmas()(3), 8.0);
  EXPECT_DOUBLE_EQ(imaging.prior_sigmas()(5), 0.02);
  Eigen::VectorXd values = imaging.values();
  values(0) = 0.03;
  values(1) = 335;
  imaging.set_values(values);
  EXPECT_EQ(imaging.readout_s(), 0.03);
  EXPECT_EQ(imaging.camera().params()[0], 335);
  EXPECT_NEAR(imaging.neighbors(0)[1].params()[0] - imaging.neighbors(0)[0].params()[0], 2 * imaging.step(0), 1e-9);
  EXPECT_EQ(Imaging(Camera(CameraModel::kEquirectangular, 1024, 512, {1024, 512}), false, options).num_parameters(), 0);
}

TEST(SolveJointImaging, TheReadoutTimeIsFound) {
  for (const double readout_s : {0.03, -0.02, 0.0}) {
    SCOPED_TRACE(readout_s);
    MovingCamera moving;
    const JointResult result = moving.solve(readout_s, with_readout());
    const SharedErrors& shared = result.shared.at(1);
    ASSERT_TRUE(shared.readout);
    EXPECT_NEAR(shared.readout->value, readout_s, 0.001);
    EXPECT_LT(std::abs(shared.readout->value - readout_s), 4 * shared.readout->sigma);
    EXPECT_LT(shared.readout->sigma, 0.003);
    EXPECT_LT(moving.worst_shift_px(result), 0.5);
    EXPECT_LT((result.poses[1].motion - shared.readout->value * moving.velocities[1]).norm(), 1e-12);
  }
}

TEST(SolveJointImaging, AGlobalShutterMisplacesImagesOfARollingOne) {
  MovingCamera moving;
  const JointResult result = moving.solve(0.03, with_global_shutter());
  EXPECT_FALSE(result.shared.at(1).readout);
  EXPECT_TRUE(result.poses[1].motion.isZero());
  EXPECT_GT(moving.worst_shift_px(result), 1.0);
}

TEST(SolveJointImaging, IntrinsicsAreFound) {
  MovingCamera moving;
  moving.given_camera = Camera(CameraModel::kOpenCv, 640, 480, {333, 331, 319, 240, -0.07, 0.02, 0.0, 0.0});
  EXPECT_GT(moving.worst_shift_px(moving.solve(0.0, with_global_shutter())), 0.5);
  const JointResult result = moving.solve(0.0, with_intrinsics());
  const std::vector<double>& found = result.cameras.at(1).params();
  const std::vector<Estimate>& changes = result.shared.at(1).intrinsics;
  ASSERT_EQ(changes.size(), 8u);
  for (size_t k = 0; k < 8; ++k) {
    EXPECT_NEAR(found[k], moving.given_camera.params()[k] + changes[k].value, 1e-9) << k;
    EXPECT_LT(std::abs(found[k] - moving.true_camera.params()[k]), 4 * changes[k].sigma) << k;
  }
  EXPECT_NEAR(found[0], 330, 0.8);
  EXPECT_NEAR(found[1], 334, 0.8);
  EXPECT_NEAR(found[4], -0.08, 0.004);
}

TEST(SolveJointImaging, WhatTheDataDoNotDetermineIsNamed) {
  MovingCamera moving;
  for (Vector6d& v : moving.velocities) v *= 1e-3;  // hardly moves: no offset and no readout shows
  const JointResult result = moving.solve(0.0, with_readout());
  EXPECT_EQ(result.shared.at(1).undetermined, (std::vector<std::string>{"time offset", "readout"}));
  MovingCamera turning;
  EXPECT_TRUE(turning.solve(0.0, with_readout()).shared.at(1).undetermined.empty());
}

// All unknowns of a pair of images by central differences of the cost; the loss is as good as square.
TEST(JointTerms, GradientsAreThoseOfDifferences) {
  constexpr double kSquare = 1e6;
  MovingCamera moving;
  ImagingOptions options = with_intrinsics().imaging;
  options.readout_sigma_s = 0.02;
  const Imaging start(moving.given_camera, true, options);
  // At readout 0: elsewhere the turn within the motion is neglected, a percent of the derivatives.
  const Eigen::VectorXd values = start.values();
  SurfaceMatch match;
  match.pixel_a = {200, 120};
  match.point_in_map = {6, 2.5, 1.5};
  match.normal_in_map = {-1, 0, 0};
  const Eigen::Vector3d ray = moving.truth[0].rotation.conjugate() * *moving.given_camera.unproject(match.pixel_a);
  const Eigen::Vector3d center = camera_center(moving.truth[0]);
  const Eigen::Vector3d spot = center + (6 - center.x()) / ray.x() * ray;
  match.pixel_b = *moving.given_camera.project(moving.truth[1] * spot) + Eigen::Vector2d(3, -2);
  SharedPatches patches;
  patches.matches = {&match};
  patches.weights = {0.7};
  EdgeMatch edge;
  edge.x_in_map = spot;
  edge.pixel = *moving.given_camera.project(moving.truth[0] * spot) + Eigen::Vector2d(1, 2);
  edge.normal = Eigen::Vector2d(0.6, 0.8);
  edge.row_fraction = row_fraction(edge.pixel.y(), 480);

  const auto cost = [&](const Eigen::VectorXd& x, bool of_edge) {
    Imaging imaging = start;
    imaging.set_values(values + x.segment(12, start.num_parameters()));
    const ImageState a{perturb_camera(moving.truth[0], x.head<6>()), moving.velocities[0], &imaging};
    const ImageState b{perturb_camera(moving.truth[1], x.segment<6>(6)), moving.velocities[1], &imaging};
    return of_edge ? edge_term({edge}, a, 0.0, kSquare)
                   : patch_term(patches, a, b, 0.004 + x(x.size() - 1), {0.18, kSquare});
  };
  const Eigen::Index range_scale = 12 + start.num_parameters();
  const Eigen::Index n = range_scale + 1;
  const EvidenceTerm of_edge = cost(Eigen::VectorXd::Zero(n), true);
  const EvidenceTerm of_patch = cost(Eigen::VectorXd::Zero(n), false);
  ASSERT_EQ(of_edge.g.size(), 6 + start.num_parameters());
  ASSERT_EQ(of_patch.g.size(), n + start.num_parameters());
  EXPECT_GT(of_edge.cost, 0.1);
  EXPECT_GT(of_patch.cost, 0.1);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double h = k < 12 || k == range_scale ? 1e-6 : 1e-4 * start.prior_sigmas()(k - 12);
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(n, k);
    const auto slope = [&](bool edge_only) {
      return 0.5 * (cost(step, edge_only).cost - cost(-step, edge_only).cost) / (2 * h);
    };
    // Both images have one camera: its parameters stand twice, before the range scale.
    double expected = of_patch.g(k);
    if (k >= 12)
      expected = k == range_scale ? of_patch.g.tail<1>()(0) : of_patch.g(k) + of_patch.g(k + range_scale - 12);
    EXPECT_NEAR(slope(false), expected, 1e-3 * std::abs(expected) + 1e-3) << k;
    if ((k >= 6 && k < 12) || k == range_scale) continue;
    const double of_one = of_edge.g(k < 6 ? k : k - 6);
    EXPECT_NEAR(slope(true), of_one, 1e-3 * std::abs(of_one) + 1e-3) << k;
  }
}

}  // namespace
}  // namespace cpplus
