#include "cpplus/visibility/region_of_interest.h"

#include <cmath>

#include "cpplus/core/options.h"

namespace cpplus {

void VisibilityOptions::validate() const {
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(fov_widening_deg >= 0 && fov_widening_deg <= 90, "fov_widening_deg", "[0, 90]", fov_widening_deg);
  check_option(depth_tolerance_m >= 0, "depth_tolerance_m", "[0, inf)", depth_tolerance_m);
  check_option(cell_leaves > 0, "cell_leaves", "(0, inf)", cell_leaves);
  check_option(splat_radius_leaves > 0, "splat_radius_leaves", "(0, inf)", splat_radius_leaves);
}

VisibilityResult find_visible_leaves(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                     const VisibilityOptions& options) {
  options.validate();
  const double widening = options.fov_widening_deg * M_PI / 180.0;
  DepthBufferOptions buffer_options;
  buffer_options.max_distance_m = options.max_distance_m;
  buffer_options.cell_leaves = options.cell_leaves;
  buffer_options.splat_radius_leaves = options.splat_radius_leaves;
  buffer_options.min_occluder_extent = options.min_occluder_extent;
  buffer_options.margin_px = widening * camera.pixels_per_radian();

  VisibilityResult result;
  const std::vector<uint32_t> roots = select_roots(map, camera, camera_from_map, options.max_distance_m, widening);
  const std::vector<ProjectedLeaf> candidates = project_leaves(map, roots, camera, camera_from_map, buffer_options);
  const DepthBuffer buffer = render_depth_buffer(candidates, map.options().leaf_size_m, camera, buffer_options);
  result.num_roots = roots.size();
  result.num_candidates = candidates.size();
  for (const ProjectedLeaf& candidate : candidates) {
    const double farthest = buffer.farthest_range_near(candidate.pixel.cast<double>());
    if (candidate.range <= farthest + options.depth_tolerance_m) result.leaves.push_back(candidate.leaf);
  }
  return result;
}

}  // namespace cpplus
