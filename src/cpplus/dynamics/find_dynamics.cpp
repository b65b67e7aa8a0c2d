#include "cpplus/dynamics/find_dynamics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cpplus/core/error.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/fill_by_scan.h"
#include "cpplus/dynamics/leaf_surfaces.h"
#include "cpplus/dynamics/leaf_vote.h"
#include "cpplus/dynamics/see_through.h"
#include "cpplus/dynamics/standing_points.h"

namespace cpplus {
namespace {

constexpr size_t kLeavesPerTask = 1 << 15;

}  // namespace

void DynamicsOptions::validate() const {
  check_option(max_range_m > 0.0 && std::isfinite(max_range_m), "max_range_m", "(0, inf)", max_range_m);
  check_option(ray_radius_m > 0.0, "ray_radius_m", "(0, inf)", ray_radius_m);
  check_option(min_gap_m >= 0.0, "min_gap_m", "[0, inf)", min_gap_m);
  check_option(surface_gap_m >= 0.0, "surface_gap_m", "[0, inf)", surface_gap_m);
  check_option(range_gap >= 0.0 && range_gap < 1.0, "range_gap", "[0, 1)", range_gap);
  check_option(min_grazing_deg >= 0.0 && min_grazing_deg < 90.0, "min_grazing_deg", "[0, 90)", min_grazing_deg);
  check_option(plane_distance_m >= 0.0, "plane_distance_m", "[0, inf)", plane_distance_m);
  check_option(min_share >= 0.0 && min_share <= 100.0, "min_share", "[0, 100]", min_share);
  check_option(region_share >= 0.0 && region_share <= 100.0, "region_share", "[0, 100]", region_share);
  check_option(near_radius_m > 0.0 && std::isfinite(near_radius_m), "near_radius_m", "(0, inf)", near_radius_m);
  check_option(near_grazing_deg >= 0.0 && near_grazing_deg < 90.0, "near_grazing_deg", "[0, 90)", near_grazing_deg);
  check_option(near_share > 0.0 && near_share <= 100.0, "near_share", "(0, 100]", near_share);
  check_option(sure_share > 0.0 && sure_share <= 100.0, "sure_share", "(0, 100]", sure_share);
  check_option(keep_share >= 0.0 && keep_share <= 1.0, "keep_share", "[0, 1]", keep_share);
  check_option(fill_share > 0.0 && fill_share <= 1.0, "fill_share", "(0, 1]", fill_share);
  check_option(min_height_m > 0.0, "min_height_m", "(0, inf)", min_height_m);
}

DynamicsResult find_dynamics(const VoxelMap& map, const ScanSet& scans, const DynamicsOptions& options) {
  options.validate();
  LeafSurfaces surfaces = measure_leaf_surfaces(map, scans);
  const SeeThrough seen = count_see_through(map, scans, surfaces, options);
  free_memory(&surfaces.means);  // the largest of what is not needed any more
  const std::vector<uint8_t> leaf_labels =
      fill_by_scan(map, scans, surfaces.num_scans, vote_on_leaves(map, scans, surfaces, seen, options), options);

  DynamicsResult result;
  result.labels.assign(scans.first_point.back(), 0);
  std::vector<size_t> num_dynamic_points(leaf_labels.size() / kLeavesPerTask + 1, 0);
  parallel_for_chunks(leaf_labels.size(), kLeavesPerTask, [&](size_t begin, size_t end) {
    for (auto leaf = static_cast<uint32_t>(begin); leaf < end; ++leaf) {
      if (leaf_labels[leaf] == 0) continue;
      const uint32_t first = map.points_begin(map.leaf_layer(), leaf);
      const uint32_t last = map.points_end(map.leaf_layer(), leaf);
      for (uint32_t i = first; i < last; ++i) result.labels[map.input_index(i)] = 1;
      num_dynamic_points[begin / kLeavesPerTask] += last - first;
    }
  });
  result.num_dynamic = std::accumulate(num_dynamic_points.begin(), num_dynamic_points.end(), size_t{0}) +
                       label_standing_points(map, scans, leaf_labels, options.min_height_m, &result.labels);
  result.num_dynamic_leaves = static_cast<size_t>(std::count(leaf_labels.begin(), leaf_labels.end(), 1));
  return result;
}

}  // namespace cpplus
