#pragma once

#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"

namespace cpplus {

struct PlaneBufferOptions {
  /// Edge of a cell, pixels of the image. [1, inf)
  double cell_px = 4.0;
  /// Planes farther than this are not looked at, metres. (0, inf)
  double max_distance_m = 40.0;
  /// Planes with fewer points hide nothing: they may be what moved during the scan. [0, inf)
  int min_plane_points = 150;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("cell_px", cell_px, "Edge of a cell, pixels of the image.");
    visitor("max_distance_m", max_distance_m, "Planes farther than this are not looked at, metres.");
    visitor("min_plane_points", min_plane_points, "Planes with fewer points hide nothing.");
  }
};

/// What PlaneBuffer is rendered from: where each plane has points, one entry for each leaf and plane, in leaf order.
struct PlaneSurface {
  std::vector<uint32_t> leaves;
  std::vector<int32_t> plane_of;
  std::vector<Eigen::Vector3f> centers;  // mean of the plane's points in the leaf, relative to the map's origin
};

PlaneSurface collect_plane_surface(const VoxelMap& map, const PlaneSegmentation& planes,
                                   const PlaneBufferOptions& options);

/// Draws each leaf's patch of plane as a square of the leaf's size, turned to the camera, nearest first in each cell;
/// the range compared is the plane's own along the cell's ray. Linear in the leaves in view.
PlaneBuffer render_plane_buffer(const VoxelMap& map, const PlaneSegmentation& planes, const PlaneSurface& surface,
                                const Camera& camera, const Rigid3& camera_from_map, const PlaneBufferOptions& options);

}  // namespace cpplus
