#include "cpplus/dynamics/find_dynamics.h"

#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/dynamics/leaf_surfaces.h"
#include "cpplus/dynamics/leaf_vote.h"
#include "cpplus/dynamics/see_through.h"

namespace cpplus {

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
  check_option(fill_share > 0.0 && fill_share <= 1.0, "fill_share", "(0, 1]", fill_share);
  check_option(keep_share >= 0.0 && keep_share <= 1.0, "keep_share", "[0, 1]", keep_share);
  check_option(sure_scans >= 1, "sure_scans", "[1, inf)", sure_scans);
}

DynamicsResult find_dynamics(const VoxelMap& map, const ScanSet& scans, const DynamicsOptions& options) {
  options.validate();
  const double max_range_roots = options.max_range_m / map.options().root_size_m;
  check_option(max_range_roots <= LeafRayCaster::max_radius_roots, "max_range_m / root_size_m", "(0, 128]",
               max_range_roots);
  LeafSurfaces surfaces = measure_leaf_surfaces(map, scans);
  const std::vector<uint32_t> num_through = count_see_through(map, scans, surfaces, options);
  surfaces.means = {};  // the largest of what is not needed any more
  const std::vector<uint8_t> leaf_labels = vote_on_leaves(map, scans, surfaces, num_through, options);

  DynamicsResult result;
  for (const uint8_t label : leaf_labels) result.num_dynamic_leaves += label;
  result.labels.assign(scans.points.size(), 0);
  for (size_t i = 0; i < result.labels.size(); ++i) {
    const uint32_t leaf = surfaces.leaf_of_point[i];
    if (leaf != no_voxel) result.labels[i] = leaf_labels[leaf];
    result.num_dynamic += result.labels[i];
  }
  return result;
}

}  // namespace cpplus
