#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// How what is wrong with a number changes from image to image: a stationary process with exponential memory
/// (Ornstein and Uhlenbeck 1930),
///
///   E x(s) x(t) = sigma^2 exp(-|t - s| / memory),
///
/// from independent errors (memory 0) to an almost constant one. In time order it is a chain: given the one before, x
/// is normal with mean a x_before, a = exp(-gap / memory), and variance sigma^2 (1 - a^2).
struct DriftProcess {
  double sigma = 1.0;
  double memory = 1.0;  // in the unit of the gaps

  double correlation(double gap) const;
  /// Standard deviation given the one a gap before.
  double innovation_sigma(double gap) const;
};

/// Expected products of a pair of neighbours, given the data.
struct DriftPair {
  double gap = 1.0;
  double before_before = 0.0;
  double before_now = 0.0;
  double now_now = 0.0;
};

/// The process under which the pairs, and the expected squares of the first numbers of some chains, are most likely:
/// the maximisation of an expectation maximisation. sigma is at least min_sigma and at most max_sigma.
DriftProcess most_likely_drift(const std::vector<double>& first_squares, const std::vector<DriftPair>& pairs,
                               double min_sigma, double max_sigma);

/// Drift of a pose in units of its prior's standard deviations: one process for the rotation, one for the translation.
struct PoseDrift {
  DriftProcess rotation;
  DriftProcess translation;

  Vector6d correlations(double gap) const { return both(rotation.correlation(gap), translation.correlation(gap)); }
  Vector6d sigmas() const { return both(rotation.sigma, translation.sigma); }
  Vector6d innovation_sigmas(double gap) const {
    return both(rotation.innovation_sigma(gap), translation.innovation_sigma(gap));
  }

 private:
  static Vector6d both(double rotation, double translation) {
    Vector6d result;
    result << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
    return result;
  }
};

}  // namespace cpplus
