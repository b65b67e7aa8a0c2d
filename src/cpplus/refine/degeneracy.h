#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct Degeneracy {
  /// Eigenvalues, ascending, of the data's information in units of the prior's.
  Vector6d eigenvalues = Vector6d::Zero();
  /// Of data and prior together.
  Matrix6d covariance = Matrix6d::Zero();
  /// Directions that the prior knows better than the data, the worst first, by name: "translation z", "rotation y", or
  /// "rotation y + translation x" where two components move together.
  std::vector<std::string> weak_directions;
};

/// Finds the directions that the data does not determine. `information` (6x6, per rad^2 / m^2) is of the perturbation
/// in geometry/rigid3.h, data only; `prior_sigmas` (rad, rad, rad, m, m, m) scales rotation and translation to one
/// unit, which is what makes eigenvalues of a mixed matrix comparable.
Degeneracy analyse_information(const Matrix6d& information, const Vector6d& prior_sigmas);

/// Name of the direction along which a pose of that covariance is least certain, in units of the prior.
std::string least_known_direction(const Matrix6d& covariance, const Vector6d& prior_sigmas);

}  // namespace cpplus
