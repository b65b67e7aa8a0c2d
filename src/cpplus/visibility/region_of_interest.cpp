#include "cpplus/visibility/region_of_interest.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/error.h"
#include "cpplus/core/options.h"
#include "cpplus/visibility/hidden_point_removal.h"

namespace cpplus {
namespace {

DepthBufferOptions buffer_options_of(const VisibilityOptions& options, const Camera& camera) {
  DepthBufferOptions result;
  result.max_distance_m = options.max_distance_m;
  result.cell_leaves = options.cell_leaves;
  result.splat_radius_leaves = options.splat_radius_leaves;
  result.min_occluder_extent = options.method == "depth_buffer" ? options.min_occluder_extent : 0.0;
  result.margin_px = options.fov_widening_deg * M_PI / 180.0 * camera.pixels_per_radian();
  return result;
}

std::vector<uint32_t> visible_in_depth_buffer(const std::vector<ProjectedLeaf>& candidates, const DepthBuffer& buffer,
                                              const VisibilityOptions& options) {
  constexpr double kMaxReach = 16.0;  // cells; for leaves within arm's length of the camera
  const double footprint_cells = options.footprint_leaves * buffer.leaf_size_m * buffer.camera.pixels_per_radian() /
                                 buffer.cell_px;  // at range 1 m
  std::vector<uint32_t> visible;
  for (const ProjectedLeaf& candidate : candidates) {
    const Eigen::Vector2d pixel = candidate.pixel.cast<double>();
    const double least_range = candidate.range - options.depth_tolerance_m;
    const int reach = static_cast<int>(std::lround(std::min(footprint_cells / candidate.range, kMaxReach)));
    if (buffer.farthest_range_near(pixel) >= least_range ||
        (reach > 1 && buffer.farthest_range_near(pixel, reach) >= least_range))
      visible.push_back(candidate.leaf);
  }
  return visible;
}

/// Section III-B of the paper: the operator on the centres of the leaves.
std::vector<uint32_t> visible_on_hull(const VoxelMap& map, const std::vector<ProjectedLeaf>& candidates,
                                      const Rigid3& camera_from_map, double radius_factor) {
  std::vector<Eigen::Vector3d> centers;
  centers.reserve(candidates.size());
  for (const ProjectedLeaf& candidate : candidates)
    centers.push_back(camera_from_map * map.center(map.leaf_layer(), candidate.leaf));
  std::vector<uint32_t> visible = remove_hidden_points(centers, radius_factor);
  for (uint32_t& index : visible) index = candidates[index].leaf;
  return visible;
}

/// Adds the candidates among the neighbours of the leaves. All lists ascending.
void dilate(const VoxelMap& map, const std::vector<ProjectedLeaf>& candidates, std::vector<uint32_t>* leaves) {
  std::vector<uint32_t> around;
  std::vector<uint32_t> reached = *leaves;
  for (const uint32_t leaf : *leaves) {
    map.neighbors(map.leaf_layer(), leaf, false, &around);
    reached.insert(reached.end(), around.begin(), around.end());
  }
  std::sort(reached.begin(), reached.end());
  reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
  leaves->clear();
  auto candidate = candidates.begin();
  for (const uint32_t leaf : reached) {
    while (candidate != candidates.end() && candidate->leaf < leaf) ++candidate;
    if (candidate != candidates.end() && candidate->leaf == leaf) leaves->push_back(leaf);
  }
}

}  // namespace

void VisibilityOptions::validate() const {
  if (method != "depth_buffer" && method != "hidden_points")
    throw Error("method must be depth_buffer or hidden_points, got " + method);
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(fov_widening_deg >= 0 && fov_widening_deg <= 90, "fov_widening_deg", "[0, 90]", fov_widening_deg);
  check_option(dilation >= 0 && dilation <= 8, "dilation", "[0, 8]", dilation);
  check_option(radius_factor >= 0.5, "radius_factor", "[0.5, inf)", radius_factor);
  check_option(depth_tolerance_m >= 0, "depth_tolerance_m", "[0, inf)", depth_tolerance_m);
  check_option(footprint_leaves >= 0 && footprint_leaves <= 4, "footprint_leaves", "[0, 4]", footprint_leaves);
  check_option(cell_leaves > 0, "cell_leaves", "(0, inf)", cell_leaves);
  check_option(splat_radius_leaves > 0, "splat_radius_leaves", "(0, inf)", splat_radius_leaves);
  check_option(min_occluder_extent >= 0 && min_occluder_extent <= 1, "min_occluder_extent", "[0, 1]",
               min_occluder_extent);
}

VisibilityResult find_visible_leaves(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                     const VisibilityOptions& options) {
  options.validate();
  const DepthBufferOptions buffer_options = buffer_options_of(options, camera);
  const std::vector<uint32_t> roots =
      select_roots(map, camera, camera_from_map, options.max_distance_m, options.fov_widening_deg * M_PI / 180.0);
  const std::vector<ProjectedLeaf> leaves = project_leaves(map, roots, camera, camera_from_map, buffer_options);
  std::vector<ProjectedLeaf> candidates;
  std::copy_if(leaves.begin(), leaves.end(), std::back_inserter(candidates), [&](const ProjectedLeaf& leaf) {
    return camera.in_image(leaf.pixel.cast<double>(), -0.5 - buffer_options.margin_px);
  });
  VisibilityResult result;
  result.num_roots = roots.size();
  result.num_candidates = candidates.size();
  if (options.method == "hidden_points") {
    result.leaves = visible_on_hull(map, candidates, camera_from_map, options.radius_factor);
    for (int ring = 0; ring < options.dilation; ++ring) dilate(map, candidates, &result.leaves);
  } else {
    const DepthBuffer buffer = render_depth_buffer(leaves, map.options().leaf_size_m, camera, buffer_options);
    result.leaves = visible_in_depth_buffer(candidates, buffer, options);
  }
  return result;
}

}  // namespace cpplus
