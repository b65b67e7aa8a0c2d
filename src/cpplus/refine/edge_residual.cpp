#include "cpplus/refine/edge_residual.h"

#include <algorithm>
#include <cmath>

namespace cpplus {

EdgeResidual summarise_distances(std::vector<double> distances_px, double last_radius_px) {
  EdgeResidual residual;
  residual.num_samples = static_cast<int>(distances_px.size());
  if (distances_px.empty()) return residual;
  double squares = 0.0;
  int inliers = 0;
  for (const double distance : distances_px) {
    squares += distance * distance;
    inliers += distance < last_radius_px;
  }
  residual.rms_px = std::sqrt(squares / static_cast<double>(distances_px.size()));
  residual.inlier_share = static_cast<double>(inliers) / static_cast<double>(distances_px.size());
  const auto middle = distances_px.begin() + static_cast<std::ptrdiff_t>(distances_px.size() / 2);
  std::nth_element(distances_px.begin(), middle, distances_px.end());
  residual.median_px = *middle;
  return residual;
}

}  // namespace cpplus
