#pragma once

#include <span>
#include <vector>

#include "cpplus/cloud/map_edge.h"
#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"

namespace cpplus {

struct IntensityEdgeOptions {
  /// Off: geometry only.
  bool enabled = true;
  /// Shortest edge, metres. (0, inf)
  double min_length_m = 0.3;
  /// Longer edges are cut into pieces, metres. (0, inf)
  double max_length_m = 1.5;
  /// Smallest change of intensity across an edge as a share of the mean of both sides. (0, 2)
  double min_contrast = 0.25;
  /// The same in standard deviations of the intensity within a side. (0, inf)
  double min_contrast_sigmas = 1.5;
  /// Standard deviation of an edge's position across itself, metres. (0, inf)
  double sigma_m = 0.008;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("enabled", enabled, "Use edges of the LiDAR intensity on planes (road markings, frames, posters).");
    visitor("min_length_m", min_length_m, "Shortest edge, metres.");
    visitor("max_length_m", max_length_m, "Longer edges are cut into pieces of this length, metres.");
    visitor("min_contrast", min_contrast, "Smallest change of intensity as a share of the mean of both sides.");
    visitor("min_contrast_sigmas", min_contrast_sigmas, "The same in standard deviations within a side.");
    visitor("sigma_m", sigma_m, "Standard deviation of an edge's position across itself, metres.");
  }
};

/// Straight edges of the LiDAR intensity on plane instances. A change of material is seen by the camera too, more often
/// than not; the ratio of both sides does not depend on range and incidence, which scale them alike.
/// `intensities` are in map order; empty: no edges.
std::vector<MapEdge> find_intensity_edges(const VoxelMap& map, std::span<const float> intensities,
                                          const PlaneSegmentation& planes, const IntensityEdgeOptions& options);

}  // namespace cpplus
