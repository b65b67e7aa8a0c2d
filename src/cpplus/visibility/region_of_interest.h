#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/visibility/depth_buffer.h"

namespace cpplus {

struct VisibilityOptions {
  /// "depth_buffer", or "hidden_points" for the operator of the paper (see remove_hidden_points).
  std::string method = "depth_buffer";
  /// Roots farther than this from the camera are not looked at, metres. (0, inf)
  double max_distance_m = 20.0;
  /// Widening of the field of view beyond each border of the image, for the error of a coarse pose, degrees. [0, 90]
  double fov_widening_deg = 2.0;
  /// hidden_points: how many times the neighbours (of 26) of the visible leaves are added to them. [0, 8]
  int dilation = 1;
  /// hidden_points: radius of the sphere that the leaf centres are flipped over, in largest distances. [0.5, inf)
  double radius_factor = 1000.0;
  /// depth_buffer, as all that follow: how far a leaf's mean may lie behind the surface in the depth buffer, metres.
  /// [0, inf)
  double depth_tolerance_m = 0.15;
  /// A leaf is a body: it counts as seen where a point up to this far beside its mean would be, in widths of a leaf
  /// (but at least in the neighbouring cells). [0, 4]
  double footprint_leaves = 0.75;
  /// Edge of a cell of the depth buffer, in widths of a leaf seen at max_distance_m. (0, inf)
  double cell_leaves = 1.0;
  /// Half edge of the square a leaf covers in the depth buffer, in widths of a leaf. (0, inf)
  double splat_radius_leaves = 0.75;
  /// Only leaves on surfaces at least this extended hide others; 0: every leaf does. [0, 1]
  double min_occluder_extent = 0.8;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("method", method, "depth_buffer, or hidden_points: the hidden point removal operator.");
    visitor("max_distance_m", max_distance_m, "Roots farther than this from the camera are not looked at, metres.");
    visitor("fov_widening_deg", fov_widening_deg, "Widening of the field of view beyond each border, degrees.");
    visitor("dilation", dilation, "hidden_points: how many times the visible leaves' neighbours are added.");
    visitor("radius_factor", radius_factor, "hidden_points: radius of the flipping sphere, in largest distances.");
    visitor("depth_tolerance_m", depth_tolerance_m, "How far a leaf may lie behind the surface drawn, metres.");
    visitor("footprint_leaves", footprint_leaves, "How far beside its mean a leaf may show, in widths of a leaf.");
    visitor("cell_leaves", cell_leaves, "Edge of a cell of the depth buffer, in widths of a leaf at max_distance_m.");
    visitor("splat_radius_leaves", splat_radius_leaves, "Half edge of the square a leaf covers, in widths of a leaf.");
    visitor("min_occluder_extent", min_occluder_extent, "Only surfaces this extended hide others; 0: every leaf does.");
  }
};

struct VisibilityResult {
  std::vector<uint32_t> leaves;  // visible leaves of the map, ascending
  size_t num_roots = 0;          // selected by distance and field of view
  size_t num_candidates = 0;     // leaves of those roots within the distance and the widened field of view
};

/// The leaves of the map that a camera sees ("region of interest", Cui & Schwertfeger 2022, section III-B). A leaf
/// stands for the mean of its points.
VisibilityResult find_visible_leaves(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                     const VisibilityOptions& options);

}  // namespace cpplus
