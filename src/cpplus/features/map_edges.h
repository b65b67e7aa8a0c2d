#pragma once

#include <span>
#include <vector>

#include "cpplus/features/boundary_edges.h"
#include "cpplus/features/crease_edges.h"
#include "cpplus/features/intensity_edges.h"

namespace cpplus {

struct MapEdgeOptions {
  CreaseEdgeOptions crease;
  BoundaryEdgeOptions boundary;
  IntensityEdgeOptions intensity;
  /// Of two edges of different kind that run side by side nearer than this, the better known one is kept, metres.
  double min_separation_m = 0.05;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor.group("crease", crease);
    visitor.group("boundary", boundary);
    visitor.group("intensity", intensity);
    visitor("min_separation_m", min_separation_m, "Of edges of different kind nearer than this one is kept, metres.");
  }
};

/// All edges of the map, of every kind: creases, then intensity edges, then boundaries; groups are distinct. A
/// boundary or intensity edge that runs along a crease (a corner whose second face the LiDAR hardly saw) says the same
/// less exactly and is left out. `intensities` as in find_intensity_edges.
std::vector<MapEdge> find_map_edges(const VoxelMap& map, std::span<const float> intensities,
                                    const PlaneSegmentation& planes, const MapEdgeOptions& options);

}  // namespace cpplus
