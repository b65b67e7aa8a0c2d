#pragma once

#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"

namespace cpplus {

struct BoundaryEdgeOptions {
  /// Off: depth-continuous edges only, as in the paper.
  bool enabled = true;
  /// Shortest edge, metres. (0, inf)
  double min_length_m = 0.25;
  /// Longer edges are cut into pieces, metres. (0, inf)
  double max_length_m = 1.5;
  /// A point is on the border when its neighbours leave an angle this wide free, degrees. (0, 360)
  double min_free_angle_deg = 130.0;
  /// Most points beyond the edge as a share of those within. [0, 1]
  double max_outside_ratio = 0.12;
  /// Largest mean distance between points across the edge, metres: sparser borders are not known well enough.
  double max_spacing_m = 0.04;
  /// Standard deviation that beam width and mixed pixels leave to an edge however many points it has, metres. (0, inf)
  double sigma_m = 0.012;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("enabled", enabled, "Use the borders of planes where something farther is seen beyond them.");
    visitor("min_length_m", min_length_m, "Shortest edge, metres.");
    visitor("max_length_m", max_length_m, "Longer edges are cut into pieces of this length, metres.");
    visitor("min_free_angle_deg", min_free_angle_deg,
            "A border point's neighbours leave an angle this wide free, degrees.");
    visitor("max_outside_ratio", max_outside_ratio, "Most points beyond the edge as a share of those within.");
    visitor("max_spacing_m", max_spacing_m, "Largest mean distance between points across the edge, metres.");
    visitor("sigma_m", sigma_m, "Standard deviation of a border however many points it has, metres.");
  }
};

/// The straight borders of plane instances. Whether one is a depth-discontinuous edge of the scene or the border of a
/// LiDAR shadow depends on the viewpoint and is decided when an image samples it. The position is corrected for
/// sampling: the outermost point of a strip with mean spacing s lies s inside the border on average.
std::vector<MapEdge> find_boundary_edges(const VoxelMap& map, const PlaneSegmentation& planes,
                                         const BoundaryEdgeOptions& options);

}  // namespace cpplus
