#include "cpplus/simulate/coarse_poses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/simulate/path.h"
#include "cpplus/simulate/scene.h"

namespace cpplus {
namespace {

TEST(SmoothNoise, HasUnitVarianceAndSmallSteps) {
  const SmoothNoise noise(3, 5.0, 20.0);
  Vector6d sum_squares = Vector6d::Zero();
  double largest_step = 0.0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    sum_squares += noise.at(0.1 * i).cwiseAbs2();
    largest_step = std::max(largest_step, (noise.at(0.1 * i + 0.1) - noise.at(0.1 * i)).cwiseAbs().maxCoeff());
  }
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(sum_squares[k] / kSamples, 1.0, 0.1);
  EXPECT_LT(largest_step, 0.1 * 2.0 * M_PI / 5.0 * std::sqrt(2.0 * 5.0));
}

TEST(CoarsePoses, LevelsHaveTheStatedRms) {
  const Scene scene = build_scene("room", 4);
  const Path path(scene.way);
  const auto pose_at = [&](double time_s) { return inverse(path.map_from_lidar(time_s)); };
  std::vector<double> stamps;
  for (int i = 0; i < 12; ++i) stamps.push_back(1.0 + i * (path.duration_s() - 2.0) / 12);
  const double rotations_deg[] = {0.3, 0.8, 2.0};
  const double translations_m[] = {0.03, 0.08, 0.2};
  const auto levels = standard_coarse_levels(4);
  ASSERT_EQ(levels.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const CoarsePoses coarse = make_coarse_poses(pose_at, stamps, levels[i]);
    double rotation = 0.0;
    double translation = 0.0;
    for (size_t k = 0; k < stamps.size(); ++k) {
      const Rigid3 truth = pose_at(stamps[k]);
      rotation += std::pow(rotation_angle_between(truth, coarse.camera_from_map[k]) * 180.0 / M_PI, 2);
      translation += (camera_center(truth) - camera_center(coarse.camera_from_map[k])).squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(rotation / 12), rotations_deg[i], 1e-6);
    EXPECT_NEAR(std::sqrt(translation / 12), translations_m[i], 1e-6);
    EXPECT_GT(std::abs(coarse.time_offset_s), 1e-4);
  }
}

TEST(CoarsePoses, ExtrinsicAloneIsOnePerturbationOfAllImages) {
  CoarseOptions options;
  options.time_offset_s = 0.0;
  options.drift_share = 0.0;
  options.noise_share = 0.0;
  const auto pose_at = [](double time_s) {
    return Rigid3(so3_exp({0.1 * time_s, 0.2, -0.3 * time_s}), {time_s, 2.0, 0.5 * time_s});
  };
  const CoarsePoses coarse = make_coarse_poses(pose_at, {0.0, 1.0, 2.5}, options);
  const Vector6d first = camera_difference(pose_at(0.0), coarse.camera_from_map[0]);
  EXPECT_NEAR(first.head<3>().norm(), 0.3 * M_PI / 180.0, 1e-9);
  EXPECT_NEAR(first.tail<3>().norm(), 0.03, 1e-9);
  EXPECT_LT((camera_difference(pose_at(2.5), coarse.camera_from_map[2]) - first).norm(), 1e-9);
}

}  // namespace
}  // namespace cpplus
