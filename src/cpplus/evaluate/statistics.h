#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace cpplus {

/// Mean, median, root mean square and maximum of a list; all NaN when it is empty.
struct SampleStatistics {
  size_t count = 0;
  double mean;
  double median;  // of an even count, the mean of the middle two
  double rms;
  double max;
};

SampleStatistics sample_statistics(std::vector<double> values);

/// The thresholds of the success shares, pixels.
inline constexpr std::array<double, 3> kSuccessThresholdsPx = {1.0, 2.0, 5.0};

/// Share of the values strictly below each of kSuccessThresholdsPx, in [0, 1]; NaN when there are none.
std::array<double, 3> success_shares(const std::vector<double>& shifts_px);

}  // namespace cpplus
