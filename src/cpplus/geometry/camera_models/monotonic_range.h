#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cpplus::camera_models {

/// c[0] + c[1] s + c[2] s^2 + ...
inline double evaluate_polynomial(const std::vector<double>& c, double s) {
  double value = 0.0;
  for (size_t i = c.size(); i-- > 0;) value = value * s + c[i];
  return value;
}

/// Positive roots of odd multiplicity (where the sign changes), ascending. Between neighbouring extrema a polynomial is
/// monotonic and has at most one root, so the roots follow from those of its derivative by bisection.
inline std::vector<double> positive_sign_changes(std::vector<double> c) {
  while (!c.empty() && c.back() == 0.0) c.pop_back();
  if (c.size() < 2) return {};
  std::vector<double> derivative;
  for (size_t i = 1; i < c.size(); ++i) derivative.push_back(static_cast<double>(i) * c[i]);

  double cauchy_bound = 0.0;  // no root lies beyond it
  for (size_t i = 0; i + 1 < c.size(); ++i) cauchy_bound = std::max(cauchy_bound, std::abs(c[i] / c.back()));
  std::vector<double> borders = positive_sign_changes(derivative);
  borders.push_back(1.0 + cauchy_bound);

  std::vector<double> roots;
  double low = 0.0;
  for (const double border : borders) {
    const bool low_is_negative = evaluate_polynomial(c, low) < 0.0;
    double high = std::max(border, low);
    if (low_is_negative != (evaluate_polynomial(c, high) < 0.0)) {
      double a = low;
      double b = high;
      for (int i = 0; i < 200 && a < b; ++i) {
        const double middle = 0.5 * (a + b);
        if (middle <= a || middle >= b) break;
        ((evaluate_polynomial(c, middle) < 0.0) == low_is_negative ? a : b) = middle;
      }
      roots.push_back(b);
    }
    low = high;
  }
  return roots;
}

/// The smallest of positive_sign_changes(), infinity if there is none.
inline double first_positive_sign_change(const std::vector<double>& c) {
  const std::vector<double> roots = positive_sign_changes(c);
  return roots.empty() ? std::numeric_limits<double>::infinity() : roots.front();
}

/// r in [0, max_radius) with forward(r) == target, for a forward that rises from forward(0) = 0. `forward(r, &slope)`
/// returns the value and its derivative. Newton steps, halved intervals where they leave the bracket. NaN when the
/// target is not reached.
template <typename Forward>
double invert_monotonic(double target, double max_radius, const Forward& forward) {
  if (!(target >= 0.0)) return std::numeric_limits<double>::quiet_NaN();
  double slope = 0.0;
  double high = std::min(max_radius, std::max(1.0, 2.0 * target));
  while (high < max_radius && forward(high, &slope) < target) {
    high *= 2.0;
    if (high > 1e9) return std::numeric_limits<double>::quiet_NaN();
    high = std::min(high, max_radius);
  }
  if (!(forward(high, &slope) >= target)) return std::numeric_limits<double>::quiet_NaN();

  double low = 0.0;
  double r = std::min(target, high);
  for (int i = 0; i < 100; ++i) {
    const double error = forward(r, &slope) - target;
    (error > 0.0 ? high : low) = r;
    double next = r - error / slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double step = std::abs(next - r);
    r = next;
    if (step <= 1e-15 * std::max(1.0, r)) break;
  }
  return r;
}

}  // namespace cpplus::camera_models
