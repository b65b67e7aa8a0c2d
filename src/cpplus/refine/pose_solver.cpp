#include "cpplus/refine/pose_solver.h"

#include <ceres/tiny_solver.h>

#include <cmath>

namespace cpplus {
namespace {

// Change of the squared normalised residuals' sum below which a pose moves by less than a thirtieth of its standard
// deviation.
constexpr double kNoticeableCost = 1e-3;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Right Jacobian of SO(3): Exp(v + dv) = Exp(v) Exp(J dv).
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const Eigen::Matrix3d s = skew(v);
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() - 0.5 * s;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / (angle * angle) * s +
         (angle - std::sin(angle)) / (angle * angle * angle) * s * s;
}

// The robust residual of a plain one and its derivative by it.
struct RobustValue {
  double value;
  double slope;
};

// log(1 + x) for x >= 0 in half the time of std::log1p: what that is better at is covered by the series.
double log_1p(double x) { return x < 1e-4 ? x * (1.0 - x * (0.5 - x / 3.0)) : std::log(1.0 + x); }

RobustValue cauchy(double residual, double weight, double scale) {
  const double s = residual / scale;
  const double root = scale * std::sqrt(weight * log_1p(s * s));
  // sqrt(log(1 + s^2)) / s goes to 1 at 0, where its formula is 0 / 0.
  if (std::abs(s) < 1e-6) return {std::sqrt(weight) * residual, std::sqrt(weight)};
  return {std::copysign(root, residual), weight * scale * std::abs(s) / ((1.0 + s * s) * root)};
}

}  // namespace

PoseResiduals::PoseResiduals(const Camera& camera, const Rigid3& base_camera_from_map,
                             const std::vector<EdgeMatch>& matches, const PoseGuess& guess, double loss_scale)
    : camera_(camera),
      matches_(matches),
      base_camera_from_map_(base_camera_from_map),
      prior_mean_(camera_difference(base_camera_from_map, guess.camera_from_map)),
      prior_root_information_(guess.root().triangularView<Eigen::Lower>().solve(Matrix6d::Identity())),
      loss_scale_(loss_scale) {}

bool PoseResiduals::operator()(const double* delta, double* residuals, double* jacobian) const {
  const Eigen::Map<const Vector6d> d(delta);
  const auto num_matches = static_cast<Eigen::Index>(matches_.size());
  Eigen::Map<Eigen::VectorXd> r(residuals, num_matches + 6);
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6>> j(jacobian, jacobian ? num_matches + 6 : 0, 6);

  const Eigen::Matrix3d unturn = so3_exp(-d.head<3>());
  const Eigen::Matrix3d camera_from_map = unturn * base_camera_from_map_.rotation.toRotationMatrix();
  const Eigen::Vector3d offset = unturn * (base_camera_from_map_.translation - d.tail<3>());
  const Eigen::Matrix3d turning = right_jacobian(d.head<3>());
  for (Eigen::Index i = 0; i < num_matches; ++i) {
    const EdgeMatch& m = matches_[static_cast<size_t>(i)];
    const Eigen::Vector3d x = camera_from_map * m.x_in_map + offset;
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> d_pixel_d_x;
    if (!camera_.project(x, &pixel, jacobian ? &d_pixel_d_x : nullptr)) {
      r(i) = 0.0;
      if (jacobian) j.row(i).setZero();
      continue;
    }
    const RobustValue robust = cauchy(m.normal.dot(pixel - m.pixel) / m.sigma_px, m.weight, loss_scale_);
    r(i) = robust.value;
    if (!jacobian) continue;
    const Eigen::Vector3d slope = d_pixel_d_x.transpose() * (robust.slope / m.sigma_px * m.normal);
    j.row(i).head<3>() = slope.cross(x).transpose() * turning;  // slope^T skew(x) = (slope x x)^T
    j.row(i).tail<3>() = -slope.transpose() * unturn;
  }
  r.tail<6>() = prior_root_information_ * (d - prior_mean_);
  if (jacobian) j.bottomRows<6>() = prior_root_information_;
  return true;
}

PoseSolution solve_pose(const Camera& camera, const Rigid3& start_camera_from_map,
                        const std::vector<EdgeMatch>& matches, const PoseGuess& guess, double loss_scale,
                        int max_iterations) {
  const PoseResiduals residuals(camera, start_camera_from_map, matches, guess, loss_scale);
  ceres::TinySolver<PoseResiduals> solver;
  solver.options.max_num_iterations = max_iterations;
  solver.options.function_tolerance = kNoticeableCost;
  Vector6d delta = Vector6d::Zero();
  solver.Solve(residuals, &delta);
  if (!delta.allFinite()) return {start_camera_from_map, solver.summary.iterations};
  return {perturb_camera(start_camera_from_map, delta), solver.summary.iterations};
}

}  // namespace cpplus
