#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/depth_buffer.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct DepthBufferOptions {
  /// Leaves farther than this from the camera centre neither hide nor are seen, metres. (0, inf)
  double max_distance_m = 20.0;
  /// Edge of a cell of the buffer, in widths of a leaf seen at max_distance_m, at the principal point. A cell is never
  /// smaller than a pixel. (0, inf)
  double cell_leaves = 1.0;
  /// Half edge of the square that a leaf covers, in widths of a leaf. 0.5 would just close a surface whose leaves are
  /// all occupied; gaps up to twice this are closed. (0, inf)
  double splat_radius_leaves = 0.75;
  /// How far the buffer goes beyond each border of the image, pixels. [0, inf)
  double margin_px = 0.0;
  /// Only leaves on surfaces at least this extended hide others (see find_extended_nodes), so that what moved through
  /// an uncleaned map hides nothing, nor do thin things; 0: every leaf hides. [0, 1]
  double min_occluder_extent = 0.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_distance_m", max_distance_m, "Leaves farther than this from the camera are ignored, metres.");
    visitor("cell_leaves", cell_leaves, "Edge of a cell, in widths of a leaf seen at max_distance_m.");
    visitor("splat_radius_leaves", splat_radius_leaves, "Half edge of the square a leaf covers, in widths of a leaf.");
    visitor("margin_px", margin_px, "How far the buffer goes beyond each border of the image, pixels.");
    visitor("min_occluder_extent", min_occluder_extent, "Only surfaces this extended hide others; 0: every leaf does.");
  }
};

/// A leaf as a camera sees it, by the mean of its points.
struct ProjectedLeaf {
  uint32_t leaf = 0;
  float range = 0.0f;     // metres
  Eigen::Vector2f pixel;  // may lie outside the image
  bool hides = true;      // drawn into the buffer
};

/// The leaves of the given roots (ascending) whose mean point is within max_distance_m of the camera centre and
/// projects into the image widened by margin_px, or so close to it that the square they cover may reach into it;
/// ascending, whatever hides them. Says which of them hide others.
std::vector<ProjectedLeaf> project_leaves(const VoxelMap& map, const std::vector<uint32_t>& roots, const Camera& camera,
                                          const Rigid3& camera_from_map, const DepthBufferOptions& options);

/// Draws the leaves that hide others into a depth buffer. Each covers a square of splat_radius_leaves around its mean,
/// at the mean's range; the nearest wins (Z-buffer). A maximum filter of the winner's own size follows, so that
/// together they are a morphological closing of the surface: gaps up to twice the radius are filled, while silhouettes
/// stay where they are and a slanted plane keeps its ranges, which drawing alone would pull towards the camera by
/// radius * tan(incidence). Linear in the leaves and in the cells.
DepthBuffer render_depth_buffer(const std::vector<ProjectedLeaf>& leaves, double leaf_size_m, const Camera& camera,
                                const DepthBufferOptions& options);

/// project_leaves, then render_depth_buffer, on the roots around the camera.
DepthBuffer render_depth_buffer(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                const DepthBufferOptions& options);

}  // namespace cpplus
