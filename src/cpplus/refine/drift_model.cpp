#include "cpplus/refine/drift_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cpplus {
namespace {

// Memories that are tried, in the unit of the gaps; finer ones make no difference that data could show.
constexpr double kMemories[] = {0.0, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0, 15.0, 25.0};
// Neighbours are never taken for equal.
constexpr double kMaxCorrelation = 0.995;

// Mean squares of innovations above so many variances count as an image that was found in a wrong place, not as a sign
// of a large drift: three axes of normal numbers have one in 1 of 33.
constexpr double kLargest = 3.0;
constexpr int kIterations = 30;

// Most likely scale of numbers whose mean squares over three axes are given; normal, with the tails of a power law.
double robust_sigma(const std::vector<double>& squares) {
  if (squares.empty()) return 0.0;
  double variance = 0.0;
  for (const double square : squares) variance += square / static_cast<double>(squares.size());
  for (int i = 0; i < kIterations; ++i) {
    double sum = 0.0;
    for (const double square : squares) sum += std::min(square, kLargest * variance);
    variance = sum / static_cast<double>(squares.size());
  }
  return std::sqrt(variance);
}

// Minus twice the logarithm of their likelihood, an axis.
double robust_cost(const std::vector<double>& squares, double sigma) {
  const double variance = sigma * sigma;
  double cost = static_cast<double>(squares.size()) * std::log(variance);
  for (const double square : squares) {
    const double ratio = square / variance;
    cost += ratio <= kLargest ? ratio : kLargest * (1.0 + std::log(ratio / kLargest));
  }
  return cost;
}

}  // namespace

double DriftProcess::correlation(double gap) const {
  return memory > 0.0 ? std::min(kMaxCorrelation, std::exp(-gap / memory)) : 0.0;
}

double DriftProcess::innovation_sigma(double gap) const {
  const double a = correlation(gap);
  return sigma * std::sqrt(1.0 - a * a);
}

DriftProcess most_likely_drift(const std::vector<double>& first_squares, const std::vector<DriftPair>& pairs,
                               double min_sigma, double max_sigma) {
  DriftProcess best{min_sigma, 0.0};
  double least = std::numeric_limits<double>::infinity();
  for (const double memory : kMemories) {
    DriftProcess process{max_sigma, memory};
    std::vector<double> squares = first_squares;  // of the innovations, in variances of the process
    double log_determinant = 0.0;
    for (const DriftPair& pair : pairs) {
      const double a = process.correlation(pair.gap);
      const double square = pair.now_now - 2.0 * a * pair.before_now + a * a * pair.before_before;
      squares.push_back(std::max(0.0, square) / (1.0 - a * a));
      log_determinant += std::log(1.0 - a * a);
    }
    process.sigma = std::clamp(robust_sigma(squares), min_sigma, max_sigma);
    const double cost = log_determinant + robust_cost(squares, process.sigma);
    if (cost < least) {
      least = cost;
      best = process;
    }
  }
  return best;
}

}  // namespace cpplus
