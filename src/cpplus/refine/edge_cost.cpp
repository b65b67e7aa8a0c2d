#include "cpplus/refine/edge_cost.h"

#include <ceres/sized_cost_function.h>

#include <cmath>

namespace cpplus {
namespace {

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

class EdgeCost : public ceres::SizedCostFunction<1, 6> {
 public:
  EdgeCost(const Camera& camera, const Eigen::Vector3d& x_in_base_camera, const Eigen::Vector2d& pixel,
           const Eigen::Vector2d& normal, double sigma_px)
      : camera_(camera), x_in_base_camera_(x_in_base_camera), pixel_(pixel), normal_(normal / sigma_px) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vector6d> delta(parameters[0]);
    const Eigen::Vector3d x = so3_exp(-delta.head<3>()) * (x_in_base_camera_ - delta.tail<3>());
    Eigen::Vector2d projected;
    Eigen::Matrix<double, 2, 3> d_pixel_d_x;
    const bool valid = camera_.project(x, &projected, &d_pixel_d_x);
    residuals[0] = valid ? normal_.dot(projected - pixel_) : 0.0;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 1, 6>> jacobian(jacobians[0]);
    jacobian.setZero();
    if (!valid) return true;
    const Eigen::RowVector3d d_residual_d_x = normal_.transpose() * d_pixel_d_x;
    jacobian.head<3>() = d_residual_d_x * skew(x) * right_jacobian(delta.head<3>());
    jacobian.tail<3>() = -d_residual_d_x * so3_exp(-delta.head<3>());
    return true;
  }

 private:
  const Camera& camera_;
  Eigen::Vector3d x_in_base_camera_;
  Eigen::Vector2d pixel_;
  Eigen::Vector2d normal_;  // divided by sigma
};

class PriorCost : public ceres::SizedCostFunction<6, 6> {
 public:
  PriorCost(const Vector6d& mean, const Vector6d& sigmas) : mean_(mean), sigmas_(sigmas) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vector6d> delta(parameters[0]);
    Eigen::Map<Vector6d> residual(residuals);
    residual = (delta - mean_).cwiseQuotient(sigmas_);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
      jacobian = sigmas_.cwiseInverse().asDiagonal();
    }
    return true;
  }

 private:
  Vector6d mean_;
  Vector6d sigmas_;
};

}  // namespace

ceres::CostFunction* make_edge_cost(const Camera& camera, const Rigid3& base_camera_from_map,
                                    const Eigen::Vector3d& x_in_map, const Eigen::Vector2d& edgel_pixel,
                                    const Eigen::Vector2d& edgel_normal, double sigma_px) {
  return new EdgeCost(camera, base_camera_from_map * x_in_map, edgel_pixel, edgel_normal, sigma_px);
}

ceres::CostFunction* make_prior_cost(const Vector6d& mean, const Vector6d& sigmas) {
  return new PriorCost(mean, sigmas);
}

}  // namespace cpplus
