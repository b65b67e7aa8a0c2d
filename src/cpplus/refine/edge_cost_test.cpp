#include "cpplus/refine/edge_cost.h"

#include <ceres/cost_function.h>
#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <memory>

namespace cpplus {
namespace {

struct CameraCase {
  const char* name;
  Camera camera;
};

std::vector<CameraCase> cameras() {
  return {{"PINHOLE", Camera(CameraModel::kPinhole, 640, 480, {400, 410, 320, 240})},
          {"OPENCV", Camera(CameraModel::kOpenCv, 640, 480, {400, 410, 320, 240, -0.2, 0.05, 0.001, -0.002})},
          {"OPENCV_FISHEYE",
           Camera(CameraModel::kOpenCvFisheye, 640, 480, {200, 205, 320, 240, 0.02, -0.01, 0.002, -0.0005})}};
}

Rigid3 some_pose() { return Rigid3(Eigen::Quaterniond(so3_exp({0.3, -1.1, 0.6})), Eigen::Vector3d(0.4, -2.0, 1.5)); }

std::vector<Vector6d> perturbations() {
  Vector6d small, large, turned;
  small << 0.002, -0.001, 0.003, 0.01, -0.02, 0.005;
  large << 0.25, -0.3, 0.4, 0.3, -0.2, 0.25;
  turned << -0.1, 0.2, 2.8, -0.1, 0.1, 0.4;  // nearly half a turn about the optical axis
  return {Vector6d::Zero(), small, large, turned};
}

TEST(EdgeCost, AHandComputedResidual) {
  // The point (0.5, 0.25, 2) is seen at (320 + 400 / 4, 240 + 410 / 8) = (420, 291.25): 3 px right of and 4 px below
  // the edgel. Along the normal (0.6, 0.8) that is 5 px, two standard deviations.
  const Camera camera = cameras()[0].camera;
  const std::unique_ptr<ceres::CostFunction> cost(
      make_edge_cost(camera, Rigid3(), {0.5, 0.25, 2.0}, {417, 287.25}, {0.6, 0.8}, 2.5));
  const Vector6d delta = Vector6d::Zero();
  const double* parameters[] = {delta.data()};
  Vector6d gradient;
  double* jacobians[] = {gradient.data()};
  double residual = 0.0;
  ASSERT_TRUE(cost->Evaluate(parameters, &residual, jacobians));
  EXPECT_NEAR(residual, 2.0, 1e-12);
  // A camera that moves right by 1 m moves the point left by 400 / 2 px: -200 * 0.6 / 2.5.
  EXPECT_NEAR(gradient(3), -48.0, 1e-9);
  EXPECT_NEAR(gradient(4), -205.0 * 0.8 / 2.5, 1e-9);
}

TEST(EdgeCost, TheResidualIsThatOfThePerturbedCamera) {
  const Eigen::Vector2d edgel(300, 200), normal(-0.8, 0.6);
  for (const CameraCase& c : cameras()) {
    for (const Vector6d& delta : perturbations()) {
      SCOPED_TRACE(testing::Message() << c.name << " " << delta.transpose());
      const Eigen::Vector3d x_in_map = inverse(some_pose()) * Eigen::Vector3d(0.4, -0.3, 2.5);
      const std::unique_ptr<ceres::CostFunction> cost(
          make_edge_cost(c.camera, some_pose(), x_in_map, edgel, normal, 0.7));
      const double* parameters[] = {delta.data()};
      double residual = 0.0;
      ASSERT_TRUE(cost->Evaluate(parameters, &residual, nullptr));
      const auto pixel = c.camera.project(perturb_camera(some_pose(), delta) * x_in_map);
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(residual, normal.dot(*pixel - edgel) / 0.7, 1e-8);
    }
  }
}

TEST(EdgeCost, TheJacobianIsThatOfDifferences) {
  ceres::NumericDiffOptions numeric;
  numeric.relative_step_size = 1e-6;
  const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
  for (const CameraCase& c : cameras()) {
    for (const Vector6d& delta : perturbations()) {
      const Eigen::Vector3d x_in_map = inverse(some_pose()) * Eigen::Vector3d(0.4, -0.3, 2.5);
      const std::unique_ptr<ceres::CostFunction> cost(
          make_edge_cost(c.camera, some_pose(), x_in_map, {300, 200}, {0.6, 0.8}, 1.3));
      const ceres::GradientChecker checker(cost.get(), no_manifolds, numeric);
      const double* parameters[] = {delta.data()};
      ceres::GradientChecker::ProbeResults results;
      EXPECT_TRUE(checker.Probe(parameters, 1e-5, &results))
          << c.name << " at " << delta.transpose() << ": " << results.error_log;
    }
  }
}

TEST(EdgeCost, ASampleBehindTheCameraPullsNowhere) {
  const Camera camera = cameras()[0].camera;
  const std::unique_ptr<ceres::CostFunction> cost(
      make_edge_cost(camera, Rigid3(), {0.5, 0.25, -2.0}, {417, 287.25}, {0.6, 0.8}, 2.5));
  const Vector6d delta = Vector6d::Zero();
  const double* parameters[] = {delta.data()};
  Vector6d gradient = Vector6d::Ones();
  double* jacobians[] = {gradient.data()};
  double residual = 1.0;
  ASSERT_TRUE(cost->Evaluate(parameters, &residual, jacobians));
  EXPECT_EQ(residual, 0.0);
  EXPECT_EQ(gradient, Vector6d::Zero());
}

TEST(PriorCost, IsTheDistanceFromTheMeanInStandardDeviations) {
  Vector6d mean, sigmas, delta;
  mean << 0.01, 0.0, -0.02, 0.1, 0.0, -0.1;
  sigmas << 0.01, 0.01, 0.02, 0.1, 0.2, 0.1;
  delta << 0.02, 0.0, 0.02, 0.1, -0.4, 0.2;
  const std::unique_ptr<ceres::CostFunction> cost(make_prior_cost(mean, sigmas));
  const double* parameters[] = {delta.data()};
  Vector6d residual;
  ASSERT_TRUE(cost->Evaluate(parameters, residual.data(), nullptr));
  Vector6d expected;
  expected << 1, 0, 2, 0, -2, 3;
  EXPECT_LT((residual - expected).norm(), 1e-12);

  const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
  const ceres::GradientChecker checker(cost.get(), no_manifolds, ceres::NumericDiffOptions());
  ceres::GradientChecker::ProbeResults results;
  EXPECT_TRUE(checker.Probe(parameters, 1e-6, &results)) << results.error_log;
}

}  // namespace
}  // namespace cpplus
