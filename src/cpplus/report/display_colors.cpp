#include "cpplus/report/display_colors.h"

#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

// Greys between these stand for the intensities between the 2nd and the 98th of 100.
constexpr double kDarkest = 60.0, kLightest = 190.0;
constexpr uint8_t kPlainGray = 130;

std::vector<uint8_t> intensity_grays(const PointCloud& cloud) {
  if (cloud.intensities.empty()) return std::vector<uint8_t>(cloud.size(), kPlainGray);
  std::vector<float> sorted = cloud.intensities;
  const auto quantile = [&](double share) {
    const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), place, sorted.end());
    return static_cast<double>(*place);
  };
  const double low = quantile(0.02), high = quantile(0.98);
  std::vector<uint8_t> grays(cloud.size(), kPlainGray);
  if (!(high > low)) return grays;
  for (size_t i = 0; i < cloud.size(); ++i) {
    const double share = std::clamp((cloud.intensities[i] - low) / (high - low), 0.0, 1.0);
    grays[i] = static_cast<uint8_t>(std::lround(kDarkest + share * (kLightest - kDarkest)));
  }
  return grays;
}

}  // namespace

DisplayColors display_colors(const PointCloud& cloud) {
  DisplayColors result;
  result.is_colored.assign(cloud.size(), cloud.colors.empty() ? 0 : 1);
  for (size_t i = 0; i < cloud.num_views.size(); ++i) result.is_colored[i] &= cloud.num_views[i] > 0;
  result.colors = cloud.colors;
  result.colors.resize(cloud.size());
  if (std::find(result.is_colored.begin(), result.is_colored.end(), 0) == result.is_colored.end()) return result;
  const std::vector<uint8_t> grays = intensity_grays(cloud);
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (!result.is_colored[i]) result.colors[i].fill(grays[i]);
  }
  return result;
}

}  // namespace cpplus
