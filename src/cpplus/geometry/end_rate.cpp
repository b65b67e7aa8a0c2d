#include "cpplus/geometry/end_rate.h"

#include <Eigen/LU>
#include <cassert>
#include <cmath>

namespace cpplus {
namespace {

constexpr int kTrendTerms = 4;         // a cubic
constexpr double kBand = 1.3;          // highest rate of the motion, rad a sample: about 2 pi / 5
constexpr double kSampleNoise = 1e-4;  // variance of a sample relative to the motion's, which bounds the weights

double sinc(double x) { return std::abs(x) < 1e-6 ? 1.0 : std::sin(x) / x; }
double sinc_derivative(double x) { return std::abs(x) < 1e-6 ? 0.0 : (std::cos(x) - sinc(x)) / x; }

}  // namespace

// The covariance of f(s) and f(t) is sinc(band (s - t)), that of f'(0) and f(t) is -band sinc'(band t). The weights
// solve [K + noise, P; P^T, 0] [w; multipliers] = [k; p], where P holds the powers of the stamps and p those of the
// trend's derivative at zero (universal kriging).
Eigen::VectorXd end_rate_weights(const Eigen::VectorXd& stamps_s) {
  const Eigen::Index n = stamps_s.size();
  assert(n >= kTrendTerms);
  const double step_s = (stamps_s[n - 1] - stamps_s[0]) / static_cast<double>(n - 1);  // negative where they descend
  const Eigen::VectorXd x = (stamps_s.array() - stamps_s[0]) / step_s;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + kTrendTerms, n + kTrendTerms);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + kTrendTerms);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) system(i, j) = sinc(kBand * (x[i] - x[j])) + (i == j ? kSampleNoise : 0.0);
    for (int k = 0; k < kTrendTerms; ++k) system(i, n + k) = system(n + k, i) = std::pow(x[i], k);
    right[i] = -kBand * sinc_derivative(kBand * x[i]);
  }
  right[n + 1] = 1.0;
  return system.fullPivLu().solve(right).head(n) / step_s;
}

}  // namespace cpplus
