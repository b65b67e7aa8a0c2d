#pragma once

#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"

namespace cpplus {

struct CreaseEdgeOptions {
  /// Range of the angle between two planes that make an edge, degrees. (0, 90]
  double min_angle_deg = 25.0;
  /// Shortest edge, metres. (0, inf)
  double min_length_m = 0.25;
  /// Longer edges are cut into pieces, each with planes of its own, as walls bend and maps drift, metres. (0, inf)
  double max_length_m = 1.5;
  /// Both planes must have points within this distance of the edge, metres. (0, inf)
  double support_distance_m = 0.12;
  /// Largest distance between the edge and the nearest points of a plane, over and above its point spacing, metres.
  double max_gap_m = 0.03;
  /// Points this far around a piece fit its planes, metres. (0, inf)
  double fit_distance_m = 0.6;
  /// What the map's own distortion adds to the standard deviation of an edge's position, metres. [0, inf)
  double map_sigma_m = 0.004;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("min_angle_deg", min_angle_deg, "Smallest angle between two planes that make an edge, degrees.");
    visitor("min_length_m", min_length_m, "Shortest edge, metres.");
    visitor("max_length_m", max_length_m, "Longer edges are cut into pieces of this length, metres.");
    visitor("support_distance_m", support_distance_m,
            "Both planes need points within this distance of the edge, metres.");
    visitor("max_gap_m", max_gap_m,
            "Largest distance from the edge to a plane's nearest points beyond their spacing, metres.");
    visitor("fit_distance_m", fit_distance_m, "Points this far around a piece fit its planes, metres.");
    visitor("map_sigma_m", map_sigma_m, "What the map's distortion adds to an edge's standard deviation, metres.");
  }
};

/// Depth-continuous edges: the stretches where two plane instances meet and both have points (Cui & Schwertfeger 2022,
/// section IV-D). Each piece is the intersection of the two planes fitted to the points near it, without those within
/// the noise of the other plane: mixed pixels round a corner, and would pull the edge.
std::vector<MapEdge> find_crease_edges(const VoxelMap& map, const PlaneSegmentation& planes,
                                       const CreaseEdgeOptions& options);

}  // namespace cpplus
