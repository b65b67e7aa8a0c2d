#include "cpplus/refine/pose_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace cpplus {
namespace {

using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 6>;

std::vector<std::pair<const char*, Camera>> cameras() {
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

EdgeMatch match(const Eigen::Vector3d& x_in_map, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
                double sigma_px, double weight = 1.0) {
  EdgeMatch m;
  m.x_in_map = x_in_map;
  m.pixel = pixel;
  m.normal = normal;
  m.sigma_px = sigma_px;
  m.weight = weight;
  return m;
}

PoseGuess wide_guess(const Rigid3& camera_from_map) { return {camera_from_map, Vector6d(Vector6d::Constant(1e6))}; }

Eigen::VectorXd evaluate(const PoseResiduals& residuals, const Vector6d& delta, Jacobian* jacobian) {
  Eigen::VectorXd r(residuals.NumResiduals());
  if (jacobian) jacobian->resize(residuals.NumResiduals(), 6);
  EXPECT_TRUE(residuals(delta.data(), r.data(), jacobian ? jacobian->data() : nullptr));
  return r;
}

TEST(PoseResiduals, AHandComputedResidual) {
  // The point (0.5, 0.25, 2) is seen at (320 + 400 / 4, 240 + 410 / 8) = (420, 291.25): 3 px right of and 4 px below
  // the edgel. Along the normal (0.6, 0.8) that is 5 px, two standard deviations.
  const Camera camera = cameras()[0].second;
  const std::vector<EdgeMatch> matches = {match({0.5, 0.25, 2.0}, {417, 287.25}, {0.6, 0.8}, 2.5, 0.5)};
  constexpr double kScale = 1.5;
  const PoseResiduals residuals(camera, Rigid3(), matches, wide_guess(Rigid3()), kScale);
  Jacobian jacobian;
  const Eigen::VectorXd r = evaluate(residuals, Vector6d::Zero(), &jacobian);
  ASSERT_EQ(r.size(), 7);
  // Half of Cauchy's loss of a residual of 2.
  EXPECT_NEAR(r(0) * r(0), 0.5 * 2.25 * std::log(1.0 + 4.0 / 2.25), 1e-12);
  // A camera that moves right by 1 m moves the point left by 400 / 2 px: -200 * 0.6 / 2.5 in plain residuals. The
  // gradient of half the loss is w rho'(4) r dr = 0.5 / (1 + 4 / 2.25) * 2 * -48.
  EXPECT_NEAR(r(0) * jacobian(0, 3), 0.5 / (1.0 + 4.0 / 2.25) * 2.0 * -48.0, 1e-9);
  EXPECT_NEAR(jacobian(0, 4) / jacobian(0, 3), 205.0 * 0.8 / (200.0 * 0.6), 1e-9);
}

TEST(PoseResiduals, AreThoseOfThePerturbedCamera) {
  const Eigen::Vector2d edgel(300, 200), normal(-0.8, 0.6);
  for (const auto& [name, camera] : cameras()) {
    for (const Vector6d& delta : perturbations()) {
      SCOPED_TRACE(testing::Message() << name << " " << delta.transpose());
      const Eigen::Vector3d x_in_map = inverse(some_pose()) * Eigen::Vector3d(0.4, -0.3, 2.5);
      const std::vector<EdgeMatch> matches = {match(x_in_map, edgel, normal, 0.7)};
      constexpr double kNoLoss = 1e6;
      const PoseResiduals residuals(camera, some_pose(), matches, wide_guess(some_pose()), kNoLoss);
      const auto pixel = camera.project(perturb_camera(some_pose(), delta) * x_in_map);
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(evaluate(residuals, delta, nullptr)(0), normal.dot(*pixel - edgel) / 0.7, 1e-3);
    }
  }
}

TEST(PoseResiduals, TheJacobianIsThatOfDifferences) {
  PoseGuess guess{some_pose(), Vector6d(Vector6d::Constant(0.1))};
  guess.covariance(2, 4) = guess.covariance(4, 2) = 0.005;
  for (const auto& [name, camera] : cameras()) {
    for (const Vector6d& delta : perturbations()) {
      SCOPED_TRACE(testing::Message() << name << " " << delta.transpose());
      const Eigen::Vector3d x_in_map = inverse(some_pose()) * Eigen::Vector3d(0.4, -0.3, 2.5);
      const std::vector<EdgeMatch> matches = {match(x_in_map, {300, 200}, {0.6, 0.8}, 1.3, 0.3)};
      const PoseResiduals residuals(camera, some_pose(), matches, guess, 1.5);
      Jacobian jacobian;
      evaluate(residuals, delta, &jacobian);
      for (int k = 0; k < 6; ++k) {
        Vector6d step = Vector6d::Zero();
        step(k) = 1e-6;
        const Eigen::VectorXd numeric =
            (evaluate(residuals, delta + step, nullptr) - evaluate(residuals, delta - step, nullptr)) / 2e-6;
        EXPECT_LT((numeric - jacobian.col(k)).norm(), 1e-5 * (1.0 + jacobian.col(k).norm())) << "component " << k;
      }
    }
  }
}

TEST(PoseResiduals, ASampleBehindTheCameraPullsNowhere) {
  const Camera camera = cameras()[0].second;
  const std::vector<EdgeMatch> matches = {match({0.5, 0.25, -2.0}, {417, 287.25}, {0.6, 0.8}, 2.5)};
  Jacobian jacobian;
  const Eigen::VectorXd r =
      evaluate(PoseResiduals(camera, Rigid3(), matches, wide_guess(Rigid3()), 1.5), Vector6d::Zero(), &jacobian);
  EXPECT_EQ(r(0), 0.0);
  EXPECT_EQ(jacobian.row(0).norm(), 0.0);
}

TEST(PoseResiduals, ThePriorIsTheDistanceFromTheGuessInStandardDeviations) {
  Vector6d mean, delta, expected;
  Vector6d sigmas;
  mean << 0.0, 0.0, 0.0, 0.1, 0.0, -0.1;
  sigmas << 0.01, 0.01, 0.02, 0.1, 0.2, 0.1;
  const PoseGuess guess{perturb_camera(Rigid3(), mean), sigmas};
  delta << 0.02, 0.0, 0.02, 0.1, -0.4, 0.2;
  expected << 2, 0, 1, 0, -2, 3;
  const std::vector<EdgeMatch> none;
  const Camera camera = cameras()[0].second;
  EXPECT_LT((evaluate(PoseResiduals(camera, Rigid3(), none, guess, 1.5), delta, nullptr) - expected).norm(), 1e-12);
}

// Points on a wavy sheet, each matched along alternating directions: a well-determined pose.
std::vector<EdgeMatch> exact_matches(const Camera& camera, const Rigid3& true_pose) {
  std::vector<EdgeMatch> matches;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d x_in_camera(std::sin(1.7 * i), 0.7 * std::cos(2.9 * i), 3.0 + std::sin(0.9 * i));
    const double angle = 0.8 * i;
    matches.push_back(
        match(inverse(true_pose) * x_in_camera, *camera.project(x_in_camera), {std::cos(angle), std::sin(angle)}, 0.5));
  }
  return matches;
}

TEST(SolvePose, FindsThePoseOfExactMatchesDespiteAFalseOne) {
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    std::vector<EdgeMatch> matches = exact_matches(camera, some_pose());
    matches.push_back(matches.front());
    matches.back().pixel += Eigen::Vector2d(15, -15);
    Vector6d off;
    off << 0.004, -0.003, 0.002, 0.01, 0.01, -0.02;
    const Rigid3 start = perturb_camera(some_pose(), off);
    const PoseSolution solution = solve_pose(camera, start, matches, wide_guess(start), 1.5, 20);
    const Vector6d error = camera_difference(some_pose(), solution.camera_from_map);
    EXPECT_LT(error.head<3>().norm(), 1e-4);
    EXPECT_LT(error.tail<3>().norm(), 3e-4);
    EXPECT_GT(solution.iterations, 1);
  }
}

TEST(SolvePose, StaysAtTheGuessWithoutMatches) {
  const Camera camera = cameras()[0].second;
  const PoseSolution solution =
      solve_pose(camera, some_pose(), {}, PoseGuess(some_pose(), Vector6d(Vector6d::Ones())), 1.5, 10);
  EXPECT_LT(camera_difference(some_pose(), solution.camera_from_map).norm(), 1e-12);
}

}  // namespace
}  // namespace cpplus
