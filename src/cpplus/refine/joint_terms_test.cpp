#include "cpplus/refine/joint_terms.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

Camera opencv() { return Camera(CameraModel::kOpenCv, 640, 480, {400, 410, 320, 240, -0.2, 0.05, 0.001, -0.002}); }

Rigid3 true_pose() { return Rigid3(Eigen::Quaterniond(so3_exp({0.3, -1.1, 0.6})), Eigen::Vector3d(0.4, -2.0, 1.5)); }

/// A spot 3 m ahead that the image shows two pixels to the right of where the pose puts it.
IntensityMatch spot(const Eigen::Vector3d& x_in_camera, const Eigen::Vector2d& off_px = {2.0, 0.0}) {
  IntensityMatch match;
  match.x_in_map = inverse(true_pose()) * x_in_camera;
  match.pixel = *opencv().project(x_in_camera) + off_px;
  match.information << 4.0, 0.5, 0.5, 1.0;
  match.weight = 0.25;
  return match;
}

EvidenceTerm term_at(const std::vector<IntensityMatch>& matches, const Imaging& imaging, const Rigid3& pose,
                     double loss_scale, const Vector6d& velocity = Vector6d::Zero()) {
  EvidenceTerm term(6 + imaging.num_parameters());
  add_intensity_matches(matches, {pose, velocity, &imaging}, loss_scale, &term);
  return term;
}

TEST(AddIntensityMatches, TheCostIsCauchysOfTheWeightedSquareByHand) {
  const Imaging imaging(opencv(), false, {});
  // r = (-2, 0): r^T I r = 16; loss scale 4: 0.25 * 16 * log(1 + 1).
  EXPECT_NEAR(term_at({spot({0.2, -0.1, 3.0})}, imaging, true_pose(), 4.0).cost, 4.0 * std::log(2.0), 1e-9);
  EXPECT_NEAR(term_at({spot({0.2, -0.1, 3.0}, {0.0, 0.0})}, imaging, true_pose(), 4.0).cost, 0.0, 1e-12);
  EXPECT_EQ(term_at({}, imaging, true_pose(), 4.0).cost, 0.0);
}

TEST(AddIntensityMatches, TheGradientIsHalfTheCostsDifference) {
  ImagingOptions options;
  options.intrinsics = true;
  Imaging imaging(opencv(), true, options);
  Vector6d velocity;
  velocity << 0.3, -0.5, 0.2, 0.4, -0.8, 1.1;
  const std::vector<IntensityMatch> matches = {spot({0.2, -0.1, 3.0}), spot({-0.9, 0.6, 2.2}, {-1.0, 3.0})};
  const EvidenceTerm term = term_at(matches, imaging, true_pose(), 1.5, velocity);
  constexpr double kStep = 1e-6;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const Vector6d delta = kStep * Vector6d::Unit(k);
    const double high = term_at(matches, imaging, perturb_camera(true_pose(), delta), 1.5, velocity).cost;
    const double low = term_at(matches, imaging, perturb_camera(true_pose(), -delta), 1.5, velocity).cost;
    EXPECT_NEAR(0.5 * (high - low) / (2.0 * kStep), term.g(k), 1e-4 * term.g.norm()) << k;
  }
  const Eigen::VectorXd values = imaging.values();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double step = 1e-4 * std::max(1e-3, std::abs(values(k)));
    const auto cost_at = [&](double change) {
      Eigen::VectorXd changed = values;
      changed(k) += change;
      imaging.set_values(changed);
      return term_at(matches, imaging, true_pose(), 1.5, velocity).cost;
    };
    const double difference = 0.5 * (cost_at(step) - cost_at(-step)) / (2.0 * step);
    EXPECT_NEAR(difference, term.g(6 + k), 1e-3 * std::max(1.0, std::abs(difference))) << k;
  }
}

TEST(AddIntensityMatches, WhatIsBehindTheCameraSaysNothing) {
  const Imaging imaging(opencv(), false, {});
  IntensityMatch behind = spot({0.2, -0.1, 3.0});
  behind.x_in_map = inverse(true_pose()) * Eigen::Vector3d(0.2, -0.1, -3.0);
  const EvidenceTerm term = term_at({behind}, imaging, true_pose(), 1.5);
  EXPECT_EQ(term.cost, 0.0);
  EXPECT_TRUE(term.h.isZero());
}

}  // namespace
}  // namespace cpplus
