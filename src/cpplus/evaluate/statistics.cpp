#include "cpplus/evaluate/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cpplus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

SampleStatistics sample_statistics(std::vector<double> values) {
  if (values.empty()) return {0, kNan, kNan, kNan, kNan};
  std::sort(values.begin(), values.end());
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double value : values) {
    sum += value;
    sum_of_squares += value * value;
  }
  const size_t n = values.size();
  const double count = static_cast<double>(n);
  return {n, sum / count, 0.5 * (values[(n - 1) / 2] + values[n / 2]), std::sqrt(sum_of_squares / count),
          values.back()};
}

std::array<double, 3> success_shares(const std::vector<double>& shifts_px) {
  std::array<double, 3> shares;
  for (size_t k = 0; k < shares.size(); ++k) {
    const auto below = std::count_if(shifts_px.begin(), shifts_px.end(),
                                     [&](double shift) { return shift < kSuccessThresholdsPx[k]; });
    shares[k] = shifts_px.empty() ? kNan : static_cast<double>(below) / static_cast<double>(shifts_px.size());
  }
  return shares;
}

}  // namespace cpplus
