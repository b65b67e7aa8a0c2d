#include "cpplus/refine/shared_errors.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

constexpr double kTimeOffsetSigma = 0.1;  // seconds, prior
constexpr double kStudentDegrees = 4.0;
constexpr int kRounds = 10;

struct Equation {
  Eigen::Matrix<double, 6, 7> design;
  Vector6d correction;
  Matrix6d information;
};

}  // namespace

std::optional<SharedErrors> estimate_shared_errors(const std::vector<PoseCorrection>& corrections,
                                                   const std::vector<std::optional<Vector6d>>& velocities_per_s,
                                                   const Vector6d& prior_sigmas, const PoseSequenceOptions& options) {
  std::vector<Equation> equations;
  for (size_t i = 0; i < corrections.size(); ++i) {
    if (!corrections[i].usable || !velocities_per_s[i]) continue;
    Equation equation;
    equation.design << Matrix6d::Identity(), *velocities_per_s[i];
    equation.correction = corrections[i].correction;
    equation.information = corrections[i].information / options.covariance_inflation;
    equations.push_back(equation);
  }
  if (static_cast<int>(equations.size()) < options.min_images) return std::nullopt;

  Vector7d prior;
  prior << prior_sigmas.cwiseAbs2().cwiseInverse(), 1.0 / (kTimeOffsetSigma * kTimeOffsetSigma);
  Vector7d solution = Vector7d::Zero();
  Matrix7d normal = Matrix7d::Zero();
  double misfit = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    normal = prior.asDiagonal();
    Vector7d right = Vector7d::Zero();
    misfit = 0.0;
    for (const Equation& e : equations) {
      const Vector6d residual = e.correction - e.design * solution;
      const double squared = residual.dot(e.information * residual);
      const double weight = round == 0 ? 1.0 : std::min(1.0, (kStudentDegrees + 6.0) / (kStudentDegrees + squared));
      normal += weight * e.design.transpose() * e.information * e.design;
      right += weight * e.design.transpose() * e.information * e.correction;
      misfit += weight * squared;
    }
    solution = normal.llt().solve(right);
  }

  // Drift makes single corrections differ by more than their covariances say.
  const double scale = std::max(1.0, misfit / (6.0 * static_cast<double>(equations.size())));
  const Matrix7d covariance = scale * normal.llt().solve(Matrix7d::Identity());
  SharedErrors shared;
  shared.num_images = static_cast<int>(equations.size());
  shared.extrinsic = solution.head<6>();
  shared.extrinsic_sigmas = covariance.diagonal().head<6>().cwiseSqrt();
  shared.time_offset_s = solution(6);
  shared.time_offset_sigma_s = std::sqrt(covariance(6, 6));
  return shared;
}

}  // namespace cpplus
