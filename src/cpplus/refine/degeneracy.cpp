#include "cpplus/refine/degeneracy.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

namespace cpplus {
namespace {

// A component of a unit direction below this is not worth naming.
constexpr double kNamedComponent = 0.45;

std::string name_of(const Vector6d& direction) {
  static constexpr std::array<const char*, 6> kNames = {"rotation x",    "rotation y",    "rotation z",
                                                        "translation x", "translation y", "translation z"};
  std::string name;
  for (int i = 0; i < 6; ++i) {
    if (std::abs(direction(i)) < kNamedComponent) continue;
    if (!name.empty()) name += " + ";
    name += kNames[static_cast<size_t>(i)];
  }
  return name;
}

}  // namespace

Degeneracy analyse_information(const Matrix6d& information, const Vector6d& prior_sigmas) {
  const Matrix6d scaled = prior_sigmas.asDiagonal() * information * prior_sigmas.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scaled);
  Degeneracy degeneracy;
  degeneracy.eigenvalues = eigen.eigenvalues();
  const Matrix6d scaled_covariance = (scaled + Matrix6d::Identity()).llt().solve(Matrix6d::Identity());
  degeneracy.covariance = prior_sigmas.asDiagonal() * scaled_covariance * prior_sigmas.asDiagonal();
  for (int i = 0; i < 6 && eigen.eigenvalues()(i) < 1.0; ++i) {
    degeneracy.weak_directions.push_back(name_of(eigen.eigenvectors().col(i)));
  }
  return degeneracy;
}

std::string least_known_direction(const Matrix6d& covariance, const Vector6d& prior_sigmas) {
  const Vector6d inverse = prior_sigmas.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  return name_of(eigen.eigenvectors().col(5));
}

}  // namespace cpplus
