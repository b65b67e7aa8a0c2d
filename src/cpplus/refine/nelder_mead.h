#pragma once

#include <functional>

#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct NelderMeadOptions {
  /// Most evaluations of the cost, those of the first simplex included. [8, inf)
  int max_evaluations = 300;
  /// Ends when no corner of the simplex is farther than this from the best one, in units of the first steps. (0, inf)
  double min_size = 1e-3;
};

struct NelderMeadResult {
  Vector6d x = Vector6d::Zero();
  double cost = 0.0;
  int evaluations = 0;
};

/// Minimises a function of six parameters without derivatives by the downhill simplex of Nelder & Mead (1965), from the
/// simplex that has a corner at `start` and one a step along each axis (`steps`, none of them 0). A cost of NaN counts
/// as infinitely bad. The result is never worse than the start. Deterministic.
NelderMeadResult minimise_nelder_mead(const std::function<double(const Vector6d&)>& cost, const Vector6d& start,
                                      const Vector6d& steps, const NelderMeadOptions& options);

}  // namespace cpplus
