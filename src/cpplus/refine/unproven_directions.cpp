#include "cpplus/refine/unproven_directions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace cpplus {
namespace {

// Information, in that of the prior, from which on a direction is known well.
constexpr double kKnownWell = 12.0;
// How far to either side the likelihood must have fallen, and up to where its peak may lie, in standard deviations.
constexpr double kReach = 2.0;
constexpr std::array<double, 5> kNearPeak = {-1.0, -0.5, 0.0, 0.5, 1.0};
// Standard deviation of the place where the map's edges in one image have been put as a whole.
constexpr double kMapErrorRad = 0.05 * std::numbers::pi / 180.0;
constexpr double kMapErrorM = 0.005;
// Share of a direction that another must have of it to be it still.
constexpr double kLeastPart = 0.5;
// Keeps matrices invertible; in information of the prior.
constexpr double kRidge = 1e-9;

// The eigenvectors of the information, unit vectors in standard deviations of the prior, that are not known well and
// that `is_wanted`; one a column, as perturbations.
template <typename IsWanted>
PoseDirections little_known(const Matrix6d& information, const Vector6d& prior_sigmas, const IsWanted& is_wanted) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(
      Matrix6d(prior_sigmas.asDiagonal() * information * prior_sigmas.asDiagonal()));
  PoseDirections found(6, 0);
  for (Eigen::Index k = 0; k < 6 && eigen.eigenvalues()(k) < kKnownWell; ++k) {
    const Vector6d axis = eigen.eigenvectors().col(k);
    if (!is_wanted(axis)) continue;
    found.conservativeResize(6, found.cols() + 1);
    found.rightCols<1>() = prior_sigmas.cwiseProduct(axis);
  }
  return found;
}

// What they have become with the pose and the information: their parts among the directions that are little known now.
// Freed as they were, a direction that nothing is known of any more would take what is known beside it along.
PoseDirections still_little_known(const PoseDirections& directions, const Vector6d& prior_sigmas,
                                  const Matrix6d& information) {
  return little_known(information, prior_sigmas, [&](const Vector6d& axis) {
    return (directions.transpose() * axis.cwiseQuotient(prior_sigmas)).norm() >= kLeastPart;
  });
}

}  // namespace

PoseDirections unproven_directions(const Matrix6d& information, const Vector6d& prior_sigmas, double min_log_gain,
                                   const std::function<double(const Vector6d& delta)>& log_ratio) {
  return little_known(information, prior_sigmas, [&](const Vector6d& axis) {
    const Vector6d direction = prior_sigmas.cwiseProduct(axis);
    const auto ratio_at = [&](double sigmas) { return log_ratio(sigmas * direction); };
    double peak = -std::numeric_limits<double>::infinity();
    for (const double at : kNearPeak) peak = std::max(peak, ratio_at(at));
    return !(peak - std::max(ratio_at(-kReach), ratio_at(kReach)) >= min_log_gain);
  });
}

void free_directions(const PoseDirections& directions, const Vector6d& prior_sigmas, EvidenceTerm* term) {
  if (directions.cols() == 0) return;
  const PoseDirections free = still_little_known(directions, prior_sigmas, term->h.topLeftCorner<6, 6>());
  // Information of an unknown move of the map's edges: next to none along the directions.
  Matrix6d move = Matrix6d::Zero();
  move.diagonal() << Eigen::Vector3d::Constant(std::pow(kMapErrorRad, -2)),
      Eigen::Vector3d::Constant(std::pow(kMapErrorM, -2));
  if (free.cols() > 0) {
    const Eigen::MatrixXd along = move * free;
    move -= along * (free.transpose() * along).inverse() * along.transpose();
  }
  move.diagonal() += kRidge * prior_sigmas.cwiseAbs2().cwiseInverse();
  // The least cost over all moves stands for the cost.
  const Eigen::LDLT<Matrix6d> with_move(term->h.topLeftCorner<6, 6>() + move);
  const Eigen::MatrixXd by_pose = term->h.leftCols<6>();
  const Vector6d gradient = term->g.head<6>();
  const Vector6d best = with_move.solve(gradient);
  term->h -= by_pose * with_move.solve(by_pose.transpose());
  term->g -= by_pose * best;
  term->cost -= gradient.dot(best);
}

}  // namespace cpplus
