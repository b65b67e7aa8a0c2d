#include "cpplus/refine/pose_solver.h"

#include <ceres/tiny_solver.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

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

// Projects a sample of an edge along which the image edge lies, as matching does.
EdgeMatch projected(EdgeMatch m, const Camera& camera, const Rigid3& camera_from_map) {
  EdgeSample sample;
  sample.x_in_map = m.x_in_map;
  sample.direction_in_map = Eigen::Vector3d(0.3, 0.8, -0.5).normalized();
  m.projected = project_sample(camera, ImagePose(camera_from_map), sample).value();
  return m;
}

struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

NormalEquations normal_equations(const MatchEquations& equations, const Vector6d& delta, double loss_scale) {
  NormalEquations n;
  equations.add_normal_equations(delta, loss_scale, &n.information, &n.gradient);
  return n;
}

// Half the robust cost of one match.
double half_cost(const EdgeMatch& m, const Camera& camera, const Rigid3& camera_from_map, double loss_scale) {
  const Eigen::Vector2d pixel = camera.project(camera_from_map * m.x_in_map).value();
  const double r = m.normal.dot(pixel - m.pixel) / m.sigma_px / loss_scale;
  return 0.5 * m.weight * loss_scale * loss_scale * std::log1p(r * r);
}

TEST(MatchEquations, AHandComputedMatch) {
  // The point (0.5, 0.25, 2) is seen at (320 + 400 / 4, 240 + 410 / 8) = (420, 291.25): 3 px right of and 4 px below
  // the edgel. Along the normal (0.6, 0.8) that is 5 px, two standard deviations.
  const Camera camera = cameras()[0].second;
  const EdgeMatch m = projected(match({0.5, 0.25, 2.0}, {417, 287.25}, {0.6, 0.8}, 2.5, 0.5), camera, Rigid3());
  const NormalEquations n = normal_equations(MatchEquations({m}), Vector6d::Zero(), 1.5);
  // A camera that moves right by 1 m moves the point left by 400 / 2 px, one that moves down up by 205 px: -120 and
  // -164 px along the normal. Cauchy's loss leaves a residual of two deviations 1 / (1 + 4 / 2.25) of its weight.
  const double weight = 0.5 / 6.25 / (1.0 + 4.0 / 2.25);
  EXPECT_NEAR(n.gradient(3), weight * 5.0 * -120.0, 1e-9);
  EXPECT_NEAR(n.information(3, 3), weight * 120.0 * 120.0, 1e-9);
  EXPECT_NEAR(n.information(3, 4), weight * 120.0 * 164.0, 1e-9);
  EXPECT_NEAR(MatchEquations({m}).rms_shift_px(0.1 * Vector6d::Unit(3)), 12.0, 1e-9);
}

TEST(MatchEquations, TheGradientIsThatOfTheRobustCost) {
  for (const auto& [name, camera] : cameras()) {
    for (const Vector6d& delta : perturbations()) {
      SCOPED_TRACE(testing::Message() << name << " " << delta.transpose());
      const Rigid3 pose = perturb_camera(some_pose(), delta);
      const Eigen::Vector3d x_in_map = inverse(some_pose()) * Eigen::Vector3d(0.4, -0.3, 2.5);
      const EdgeMatch m = projected(match(x_in_map, {300, 200}, {0.6, 0.8}, 1.3, 0.3), camera, pose);
      const Vector6d gradient = normal_equations(MatchEquations({m}), Vector6d::Zero(), 1.5).gradient;
      for (int k = 0; k < 6; ++k) {
        const Vector6d step = 1e-6 * Vector6d::Unit(k);
        const double numeric = (half_cost(m, camera, perturb_camera(pose, step), 1.5) -
                                half_cost(m, camera, perturb_camera(pose, -step), 1.5)) /
                               2e-6;
        EXPECT_NEAR(gradient(k), numeric, 1e-5 * (1.0 + gradient.norm())) << "component " << k;
      }
    }
  }
}

TEST(MatchEquations, AboutAnotherPoseAreThoseOfMatchesProjectedFromIt) {
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    const Rigid3 other = perturb_camera(some_pose(), perturbations()[2]);
    const EdgeMatch m = match(inverse(some_pose()) * Eigen::Vector3d(0.4, -0.3, 2.5), {300, 200}, {0.6, 0.8}, 1.3, 0.3);
    const Vector6d delta = perturbations()[1];
    const NormalEquations expected = normal_equations(MatchEquations({projected(m, camera, other)}), delta, 1.5);
    const NormalEquations found =
        normal_equations(MatchEquations({projected(m, camera, some_pose())}, camera, other), delta, 1.5);
    EXPECT_LT((found.information - expected.information).norm(), 1e-9 * expected.information.norm());
    EXPECT_LT((found.gradient - expected.gradient).norm(), 1e-9 * expected.gradient.norm());
  }
}

TEST(MatchEquations, ASampleBehindTheCameraPullsNowhere) {
  const Camera camera = cameras()[0].second;
  const std::vector<EdgeMatch> matches = {match({0.5, 0.25, -2.0}, {417, 287.25}, {0.6, 0.8}, 2.5)};
  const NormalEquations n = normal_equations(MatchEquations(matches, camera, Rigid3()), Vector6d::Zero(), 1.5);
  EXPECT_EQ(n.gradient.norm(), 0.0);
  EXPECT_EQ(n.information.norm(), 0.0);
}

// Points on a wavy sheet, each matched along alternating directions: a well-determined pose.
std::vector<EdgeMatch> exact_matches(const Camera& camera, const Rigid3& true_pose, const Rigid3& start) {
  std::vector<EdgeMatch> matches;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d x_in_camera(std::sin(1.7 * i), 0.7 * std::cos(2.9 * i), 3.0 + std::sin(0.9 * i));
    const double angle = 0.8 * i;
    matches.push_back(projected(
        match(inverse(true_pose) * x_in_camera, *camera.project(x_in_camera), {std::cos(angle), std::sin(angle)}, 0.5),
        camera, start));
  }
  return matches;
}

TEST(SolvePose, FindsThePoseOfExactMatchesDespiteAFalseOne) {
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    Vector6d off;
    off << 0.004, -0.003, 0.002, 0.01, 0.01, -0.02;
    const Rigid3 start = perturb_camera(some_pose(), off);
    std::vector<EdgeMatch> matches = exact_matches(camera, some_pose(), start);
    matches.push_back(matches.front());
    matches.back().pixel += Eigen::Vector2d(15, -15);
    const PoseSolution solution = solve_pose(camera, start, matches, wide_guess(start), 1.5, 20);
    const Vector6d error = camera_difference(some_pose(), solution.camera_from_map);
    EXPECT_LT(error.head<3>().norm(), 1e-4);
    EXPECT_LT(error.tail<3>().norm(), 3e-4);
    EXPECT_GT(solution.iterations, 1);
  }
}

TEST(SolvePose, FindsAPoseThatIsSoFarThatTheProjectionBends) {
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    Vector6d off;
    off << 0.06, -0.05, 0.08, 0.1, 0.1, -0.15;
    const Rigid3 start = perturb_camera(some_pose(), off);
    constexpr double kNoLoss = 1e6;
    const PoseSolution solution =
        solve_pose(camera, start, exact_matches(camera, some_pose(), start), wide_guess(start), kNoLoss, 20);
    // Well below what the matches, of half a pixel each, leave open.
    EXPECT_LT(camera_difference(some_pose(), solution.camera_from_map).norm(), 2e-4);
  }
}

// The robust cost of matches and guess as Ceres wants it, nothing of it linear: residuals whose squares add up to it,
// and derivatives from differences.
class ExactResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  ExactResiduals(const Camera& camera, const Rigid3& base, const std::vector<EdgeMatch>& matches,
                 const PoseGuess& guess, double loss_scale)
      : camera_(camera), base_(base), matches_(matches), guess_(guess), loss_scale_(loss_scale) {}

  int NumResiduals() const { return static_cast<int>(matches_.size()) + 6; }

  bool operator()(const double* delta, double* residuals, double* jacobian) const {
    const Eigen::Map<const Vector6d> d(delta);
    Eigen::Map<Eigen::VectorXd>(residuals, NumResiduals()) = at(d);
    if (!jacobian) return true;
    Eigen::Map<Eigen::MatrixXd> j(jacobian, NumResiduals(), 6);
    for (int k = 0; k < 6; ++k) j.col(k) = (at(d + 1e-6 * Vector6d::Unit(k)) - at(d - 1e-6 * Vector6d::Unit(k))) / 2e-6;
    return true;
  }

 private:
  Eigen::VectorXd at(const Vector6d& delta) const {
    const Rigid3 pose = perturb_camera(base_, delta);
    Eigen::VectorXd r(NumResiduals());
    for (size_t i = 0; i < matches_.size(); ++i) {
      const EdgeMatch& m = matches_[i];
      const double residual = m.normal.dot(camera_.project(pose * m.x_in_map).value() - m.pixel);
      r(static_cast<Eigen::Index>(i)) =
          std::copysign(std::sqrt(2.0 * half_cost(m, camera_, pose, loss_scale_)), residual);
    }
    r.tail<6>() = camera_difference(guess_.camera_from_map, pose).cwiseQuotient(guess_.sigmas());
    return r;
  }

  const Camera& camera_;
  const Rigid3 base_;
  const std::vector<EdgeMatch>& matches_;
  const PoseGuess guess_;
  double loss_scale_;
};

TEST(SolvePose, FindsWhatCeresFinds) {
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    Vector6d off;
    off << 0.01, -0.008, 0.012, 0.02, 0.03, -0.02;
    const Rigid3 start = perturb_camera(some_pose(), off);
    std::vector<EdgeMatch> matches = exact_matches(camera, some_pose(), start);
    Random random(3);
    for (size_t i = 0; i < matches.size(); ++i) {
      matches[i].pixel += Eigen::Vector2d(random.normal(), random.normal()) * (i % 8 == 0 ? 6.0 : 0.5);
    }
    Vector6d sigmas;
    sigmas << Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.1);
    const PoseGuess guess(start, sigmas);
    ceres::TinySolver<ExactResiduals> ceres;
    Vector6d delta = Vector6d::Zero();
    ceres.options.max_num_iterations = 100;
    ceres.Solve(ExactResiduals(camera, start, matches, guess, 1.5), &delta);
    const Rigid3 expected = perturb_camera(start, delta);
    const Rigid3 found = solve_pose(camera, start, matches, guess, 1.5, 50).camera_from_map;
    // Within a few percent of the standard deviations, at which our solver stops.
    const Vector6d difference = camera_difference(expected, found);
    Matrix6d information = guess.covariance.inverse();
    Vector6d gradient = Vector6d::Zero();
    MatchEquations(matches, camera, found).add_normal_equations(Vector6d::Zero(), 1.5, &information, &gradient);
    EXPECT_LT(std::sqrt(difference.dot(information * difference)), 0.1);
    EXPECT_GT(camera_difference(start, found).norm(), 0.02);
  }
}

TEST(SolvePose, WeighsMatchesAgainstTheGuess) {
  // Many equal matches say that the camera is 0.1 m further right, the guess that it is where it started: with w times
  // n matches of 200 px / m and 2 px, and a guess of 0.02 m, the solution lies in between by their informations.
  const Camera camera = cameras()[0].second;
  EdgeMatch m = match({0.0, 0.0, 2.0}, {320 - 20, 240}, {1.0, 0.0}, 2.0, 0.25);
  const std::vector<EdgeMatch> matches(8, projected(m, camera, Rigid3()));
  Vector6d sigmas = Vector6d::Constant(1e-9);
  sigmas(3) = 0.02;
  constexpr double kNoLoss = 1e6;
  const PoseSolution solution = solve_pose(camera, Rigid3(), matches, PoseGuess(Rigid3(), sigmas), kNoLoss, 20);
  const double of_matches = 8 * 0.25 * 100.0 * 100.0;
  const double of_guess = 1.0 / (0.02 * 0.02);
  EXPECT_NEAR(camera_difference(Rigid3(), solution.camera_from_map)(3), 0.1 * of_matches / (of_matches + of_guess),
              1e-6);
}

TEST(SolvePose, StaysAtTheGuessWithoutMatches) {
  const Camera camera = cameras()[0].second;
  const PoseSolution solution =
      solve_pose(camera, some_pose(), {}, PoseGuess(some_pose(), Vector6d(Vector6d::Ones())), 1.5, 10);
  EXPECT_LT(camera_difference(some_pose(), solution.camera_from_map).norm(), 1e-12);
}

}  // namespace
}  // namespace cpplus
