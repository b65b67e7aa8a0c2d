#include "cpplus/geometry/trajectory.h"

#include <algorithm>

namespace cpplus {
namespace {

double median_spacing(const std::vector<StampedPose>& sorted) {
  std::vector<double> spacings;
  for (size_t i = 1; i < sorted.size(); ++i) {
    const double spacing = sorted[i].stamp_s - sorted[i - 1].stamp_s;
    if (spacing > 0.0) spacings.push_back(spacing);
  }
  if (spacings.empty()) return 0.0;
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle;
}

}  // namespace

OrderedTrajectory order_by_stamp(std::vector<StampedPose> poses) {
  constexpr double kLeastShareOfMedian = 0.05;
  OrderedTrajectory ordered;
  for (size_t i = 1; i < poses.size(); ++i) {
    if (poses[i].stamp_s >= poses[i - 1].stamp_s) continue;
    if (ordered.num_out_of_order++ == 0) ordered.first_out_of_order_s = poses[i].stamp_s;
  }
  const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.stamp_s < b.stamp_s; };
  std::stable_sort(poses.begin(), poses.end(), earlier);
  const double least = kLeastShareOfMedian * median_spacing(poses);
  for (const StampedPose& pose : poses) {
    const bool is_double = !ordered.trajectory.empty() && (pose.stamp_s - ordered.trajectory.back().stamp_s <= least);
    if (!is_double) {
      ordered.trajectory.push_back(pose);
    } else if (ordered.num_double++ == 0) {
      ordered.first_double_s = pose.stamp_s;
    }
  }
  return ordered;
}

}  // namespace cpplus
