#include "cpplus/refine/pose_solver.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace cpplus {
namespace {

// Change of the cost below which a pose moves by less than a thirtieth of its standard deviation.
constexpr double kNoticeableCost = 1e-3;
// Over so many pixels a projection is as good as linear: what bends is the square of the shift over the focal length.
constexpr double kLinearShiftPx = 0.5;

Vector6d minimise_linear(const MatchEquations& equations, const Matrix6d& prior_information, const Vector6d& prior_mean,
                         double loss_scale, int max_iterations, int* iterations) {
  Vector6d delta = Vector6d::Zero();
  while (*iterations < max_iterations) {
    ++*iterations;
    Matrix6d information = prior_information;
    Vector6d gradient = prior_information * (delta - prior_mean);
    equations.add_normal_equations(delta, loss_scale, &information, &gradient);
    const Vector6d step = information.ldlt().solve(gradient);
    delta -= step;
    if (!(step.dot(gradient) >= kNoticeableCost)) break;
  }
  return delta;
}

}  // namespace

MatchEquations::MatchEquations(const std::vector<EdgeMatch>& matches)
    : residual_px_(matches.size()),
      jacobian_(matches.size(), 6),
      variance_px2_(matches.size()),
      weight_(matches.size()) {
  for (size_t i = 0; i < matches.size(); ++i) {
    const EdgeMatch& m = matches[i];
    set(static_cast<Eigen::Index>(i), m, m.projected.pixel, m.projected.d_pixel_d_delta);
  }
}

MatchEquations::MatchEquations(const std::vector<EdgeMatch>& matches, const Camera& camera,
                               const Rigid3& camera_from_map)
    : residual_px_(Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(matches.size()))),
      jacobian_(Eigen::Matrix<double, Eigen::Dynamic, 6>::Zero(static_cast<Eigen::Index>(matches.size()), 6)),
      variance_px2_(Eigen::ArrayXd::Ones(static_cast<Eigen::Index>(matches.size()))),
      weight_(Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(matches.size()))) {
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  for (size_t i = 0; i < matches.size(); ++i) {
    const EdgeMatch& m = matches[i];
    const Eigen::Vector3d x_in_camera = rotation * m.x_in_map + camera_from_map.translation;
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> d_pixel_d_x;
    if (!camera.project(x_in_camera, &pixel, &d_pixel_d_x)) continue;
    set(static_cast<Eigen::Index>(i), m, pixel, d_pixel_d_x * d_camera_point_d_delta(x_in_camera));
  }
}

void MatchEquations::set(Eigen::Index i, const EdgeMatch& match, const Eigen::Vector2d& pixel,
                         const Eigen::Matrix<double, 2, 6>& d_pixel_d_delta) {
  residual_px_(i) = match.normal.dot(pixel - match.pixel);
  jacobian_.row(i) = match.normal.transpose() * d_pixel_d_delta;
  variance_px2_(i) = match.sigma_px * match.sigma_px;
  weight_(i) = match.weight;
}

void MatchEquations::add_normal_equations(const Vector6d& delta, double loss_scale, Matrix6d* information,
                                          Vector6d* gradient) const {
  const Eigen::VectorXd residual_px = residual_px_.matrix() + jacobian_ * delta;
  const Eigen::VectorXd weight =
      weight_ / (variance_px2_ + residual_px.array().square() * (1.0 / (loss_scale * loss_scale)));
  const Eigen::Matrix<double, Eigen::Dynamic, 6> weighted = weight.asDiagonal() * jacobian_;
  information->noalias() += weighted.transpose() * jacobian_;
  gradient->noalias() += weighted.transpose() * residual_px;
}

double MatchEquations::rms_shift_px(const Vector6d& delta) const {
  if (residual_px_.size() == 0) return 0.0;
  return (jacobian_ * delta).norm() / std::sqrt(static_cast<double>(residual_px_.size()));
}

PoseSolution solve_pose(const Camera& camera, const Rigid3& start_camera_from_map,
                        const std::vector<EdgeMatch>& matches, const PoseGuess& guess, double loss_scale,
                        int max_iterations) {
  const Matrix6d prior_information = guess.covariance.llt().solve(Matrix6d::Identity());
  PoseSolution solution;
  solution.camera_from_map = start_camera_from_map;
  MatchEquations equations(matches);
  while (solution.iterations < max_iterations) {
    const Vector6d delta = minimise_linear(equations, prior_information,
                                           camera_difference(solution.camera_from_map, guess.camera_from_map),
                                           loss_scale, max_iterations, &solution.iterations);
    if (!delta.allFinite()) return {start_camera_from_map, solution.iterations};
    solution.camera_from_map = perturb_camera(solution.camera_from_map, delta);
    if (equations.rms_shift_px(delta) < kLinearShiftPx) break;
    equations = MatchEquations(matches, camera, solution.camera_from_map);
  }
  return solution;
}

}  // namespace cpplus
