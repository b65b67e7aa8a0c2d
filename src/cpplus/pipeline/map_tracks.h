#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/colorize/cell_bearings.h"
#include "cpplus/colorize/color_samples.h"
#include "cpplus/colorize/surface_normals.h"
#include "cpplus/colorize/view_sampler.h"
#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

struct MapTrackOptions {
  /// One point of the map a voxel of this size: the map's finest layer whose voxels are at least as large. Metres,
  /// (0, inf)
  double point_voxel_m = 0.0625;
  /// Where more points than this are seen, they are thinned evenly. [1, 100000000]
  int max_points = 300000;
  /// Points that fewer images see are left out. [1, 1000]
  int min_views = 2;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("point_voxel_m", point_voxel_m, "One point a voxel of at least this size (0.0625, 0.125, ...), metres.");
    visitor("max_points", max_points, "Where more points are seen, they are thinned evenly. [1, 100000000]");
    visitor("min_views", min_views, "Points that fewer images see are left out. [1, 1000]");
  }
};

/// Samples points of a map with their tracks: which image sees which point at which pixel. Of each voxel it takes the
/// point nearest to the mean of its points, without what floats beside surfaces. Seen is what gives colour in
/// `colorize` (see ViewSampler), so neither what the map hides nor background beside a foreground. Images come one
/// after the other; kept of each are 4 bytes an observation.
class MapTracks {
 public:
  /// The map must outlive it.
  MapTracks(const VoxelMap& map, const MapTrackOptions& options, const ViewSamplingOptions& sampling);

  /// Returns how many of the sampled points the view sees. `image_id` names it in the tracks.
  size_t add_view(const ColorView& view, uint32_t image_id);

  size_t num_candidates() const { return points_.size(); }

  /// The points in map order with ids from 1, the robust mean of the colours that the images show, and tracks in the
  /// order of the views. Pixels are the projections under the views' poses, hence the error is 0. Ends the collection.
  std::vector<SparsePoint> take();

 private:
  struct View {
    uint32_t image_id = 0;
    Camera camera;
    Rigid3 camera_from_map;
    std::vector<uint32_t> seen;  // indices into points_, ascending
  };

  /// For each candidate its index among the points of the result, or -1.
  std::vector<int64_t> choose_points() const;

  const VoxelMap& map_;
  MapTrackOptions options_;
  ViewSamplingOptions sampling_;
  std::vector<uint32_t> points_;          // candidates, in map order
  std::vector<Eigen::Vector3f> normals_;  // of the candidates; zero where not known
  CellBearings bearings_;
  ColorSamples samples_;
  std::vector<View> views_;
};

}  // namespace cpplus
