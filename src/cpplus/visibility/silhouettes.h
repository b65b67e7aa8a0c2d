#pragma once

#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/visibility/outline_chains.h"
#include "cpplus/visibility/range_raster.h"

namespace cpplus {

struct SilhouetteOptions {
  bool enabled = true;
  /// Points farther than this from the camera are not looked at, metres. (0, inf)
  double max_distance_m = 40.0;
  /// Edge of a cell of the range image that outlines are traced in, pixels. [1, inf)
  double cell_px = 2.0;
  RangeJumpOptions jump;
  /// Shortest and longest straight piece, pixels. (0, inf)
  double min_length_px = 16.0;
  double max_length_px = 40.0;
  /// Largest mean distance between the points of the near surface, pixels: the outlines of sparser ones, such as people
  /// leave who walked through a single scan, are not known well enough. (0, inf)
  double max_spacing_px = 5.0;
  /// Largest RMS distance of the outermost points of a piece from its line, pixels: raggeder outlines (foliage) are no
  /// edges. (0, inf)
  double max_scatter_px = 1.5;
  /// The same along the viewing rays, metres. (0, inf)
  double max_range_scatter_m = 0.10;
  /// Standard deviation that beam width and mixed pixels leave to an outline however many points it has, metres.
  /// (0, inf)
  double sigma_m = 0.012;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("enabled", enabled, "Use the outlines of the map's surface as each image sees it.");
    visitor("max_distance_m", max_distance_m, "Points farther than this from the camera are not looked at, metres.");
    visitor("cell_px", cell_px, "Edge of a cell of the range image that outlines are traced in, pixels.");
    visitor.group("jump", jump);
    visitor("min_length_px", min_length_px, "Shortest straight piece of an outline, pixels.");
    visitor("max_length_px", max_length_px, "Longest one, pixels.");
    visitor("max_spacing_px", max_spacing_px, "Largest mean distance between points of the near surface, pixels.");
    visitor("max_scatter_px", max_scatter_px, "Largest RMS distance of a piece's outermost points from it, pixels.");
    visitor("max_range_scatter_m", max_range_scatter_m, "The same along the viewing rays, metres.");
    visitor("sigma_m", sigma_m, "Standard deviation of an outline however many points it has, metres.");
  }
};

/// The straight pieces of the outlines that the map's surface has in a view: where the near surface ends and the map
/// beyond lies clearly farther. They need no planes, so that trunks, poles, cars and signs have them. They hold near
/// this pose only: another one sees another outline of what is round.
///
/// The surface is drawn on cells (range_raster.h), its outlines are followed and cut where they bend
/// (outline_chains.h). Each piece is then fitted to the outermost points of the near surface, one a bin along it, moved
/// out by half of their mean distance as for the borders of planes: points at random end one spacing inside, wide beams
/// reach beyond. Pieces of one straight stretch share a group. leaf_spacing as leaf_point_spacing() gives it; the view
/// is that of the plane buffer, whose planes spare the points that they hide. Edges of kind kSilhouette; normal_a and
/// inward_a (towards the near surface, across the viewing ray) are unit vectors in the map frame. Linear in the points
/// in view.
std::vector<MapEdge> find_silhouettes(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                      const PlaneBuffer& planes, const SilhouetteOptions& options);

/// The same from points that are projected and drawn already.
std::vector<MapEdge> find_silhouettes(const PointsInView& view, const Camera& camera, const Rigid3& camera_from_map,
                                      const SilhouetteOptions& options);

}  // namespace cpplus
