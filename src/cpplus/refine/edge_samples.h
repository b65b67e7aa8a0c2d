#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/range_raster.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct EdgeSampleOptions {
  /// Distance between the samples of an edge in the image, pixels. (0, inf)
  double spacing_px = 6.0;
  /// Edges farther than this from the camera are not looked at, metres. (0, inf)
  double max_distance_m = 40.0;
  /// An edge is hidden when it lies this far behind a plane that is seen at its place, metres. [0, inf)
  double occlusion_margin_m = 0.04;
  /// The same behind the nearest points of the map, of planes or not, metres and share of the distance (whichever is
  /// more). [0, inf)
  double surface_margin_m = 0.10;
  double surface_margin_ratio = 0.02;
  /// A boundary counts where the map beyond it lies this far behind the plane's continuation, along the viewing ray,
  /// metres and share of the distance.
  double min_jump_m = 0.06;
  double min_jump_ratio = 0.01;
  /// How far beyond a boundary that is looked for, pixels and metres (whichever is more). (0, inf)
  double jump_offset_px = 7.0;
  double jump_offset_m = 0.05;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("spacing_px", spacing_px, "Distance between the samples of an edge in the image, pixels.");
    visitor("max_distance_m", max_distance_m, "Edges farther than this from the camera are not looked at, metres.");
    visitor("occlusion_margin_m", occlusion_margin_m,
            "An edge is hidden when it lies this far behind a plane, metres.");
    visitor("surface_margin_m", surface_margin_m, "The same behind the nearest points of the map, metres.");
    visitor("surface_margin_ratio", surface_margin_ratio,
            "The same as a share of the distance; the larger one counts.");
    visitor("min_jump_m", min_jump_m, "A boundary counts where the map beyond lies this far behind its plane, metres.");
    visitor("min_jump_ratio", min_jump_ratio, "The same as a share of the distance.");
    visitor("jump_offset_px", jump_offset_px, "How far beyond a boundary that is looked for, pixels.");
    visitor("jump_offset_m", jump_offset_m, "The same in metres; the larger one counts.");
  }
};

/// A point on a map edge that the camera should see.
struct EdgeSample {
  Eigen::Vector3d x_in_map;
  Eigen::Vector3d direction_in_map;  // unit, along the edge
  uint32_t edge = 0;                 // index of the MapEdge
  uint32_t edge_samples = 0;         // how many samples that edge has in this image
};

/// Samples every edge that may fall into the image and keeps what the planes (rendered from the same pose) do not
/// hide; of boundaries only the stretches with a depth jump as seen from this camera, which throws out the borders
/// of LiDAR shadows. Ordered by edge.
std::vector<EdgeSample> sample_visible_edges(const std::vector<MapEdge>& edges, const Camera& camera,
                                             const Rigid3& camera_from_map, const PlaneBuffer& planes,
                                             const EdgeSampleOptions& options);

/// Leaves out the samples that something hides which is no plane (a shelf, a plant): the raster, drawn from a pose that
/// is right to a pixel or two, shows a nearer surface in all of the 3x3 cells around them.
void drop_hidden_samples(const RangeRaster& raster, const Camera& camera, const Rigid3& camera_from_map,
                         const EdgeSampleOptions& options, std::vector<EdgeSample>* samples);

}  // namespace cpplus
