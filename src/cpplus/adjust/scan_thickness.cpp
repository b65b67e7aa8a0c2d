#include "cpplus/adjust/scan_thickness.h"

#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

struct PatchThickness {
  double before = 0.0;  // square metres
  double after = 0.0;
  double single_scan = 0.0;
};

PatchThickness thickness_of(const ScanPatch& patch, const std::vector<Rigid3>& new_map_from_map) {
  std::vector<double> counts;
  std::vector<ScanCluster> after;
  double sum = 0.0;
  double within = 0.0;
  for (const ScanCluster& cluster : patch.clusters) {
    counts.push_back(cluster.count);
    after.push_back(moved(cluster, new_map_from_map[cluster.scan]));
    sum += cluster.count;
    within += cluster.count * patch.normal.dot(cluster.covariance * patch.normal);
  }
  return {fit_patch_plane(patch.clusters, counts).smallest, fit_patch_plane(after, counts).smallest, within / sum};
}

void leave_out_thick(std::vector<PatchThickness>* patches) {
  constexpr double kThick = 3.0;
  std::vector<double> before;
  for (const PatchThickness& patch : *patches) before.push_back(patch.before);
  const auto middle = before.begin() + static_cast<ptrdiff_t>(before.size() / 2);
  std::nth_element(before.begin(), middle, before.end());
  const double limit = kThick * kThick * *middle;
  std::erase_if(*patches, [limit](const PatchThickness& patch) { return patch.before > limit; });
}

}  // namespace

ThicknessChange measure_thickness(const std::vector<ScanPatch>& patches, const std::vector<Rigid3>& new_map_from_map) {
  ThicknessChange change;
  if (patches.empty()) return change;
  constexpr size_t kGrain = 64;
  std::vector<PatchThickness> all(patches.size());
  parallel_for_chunks(patches.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t p = begin; p < end; ++p) all[p] = thickness_of(patches[p], new_map_from_map);
  });
  leave_out_thick(&all);

  const double n = static_cast<double>(all.size());
  PatchThickness mean;
  double squared_gains = 0.0;
  for (const PatchThickness& patch : all) {
    mean.before += patch.before / n;
    mean.after += patch.after / n;
    mean.single_scan += patch.single_scan / n;
    squared_gains += std::pow(patch.before - patch.after, 2) / n;
  }
  change.num_patches = all.size();
  change.before_m = std::sqrt(mean.before);
  change.after_m = std::sqrt(mean.after);
  change.single_scan_m = std::sqrt(mean.single_scan);
  if (mean.before <= 0.0) return change;
  const double gain = mean.before - mean.after;
  change.gain = gain / mean.before;
  change.gain_sigma = std::sqrt(std::max(squared_gains - gain * gain, 0.0) / n) / mean.before;
  return change;
}

}  // namespace cpplus
