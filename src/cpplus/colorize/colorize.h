#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/colorize/view_sampler.h"

namespace cpplus {

struct ColorizeOptions {
  ViewSamplingOptions sampling;
  /// The best samples kept of each point; memory grows with it, by 4 bytes a point. [1, 64]
  int max_samples = 8;
  /// A sample that differs by more than this from the median of its point in any channel is taken for an outlier.
  /// Grey levels, [0, 255]
  double max_deviation = 30.0;
  /// Voxels that surface normals are fitted in; metres. (0, inf)
  double normal_voxel_m = 0.25;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor.group("sampling", sampling);
    visitor("max_samples", max_samples, "The best colour samples kept of each point. [1, 64]");
    visitor("max_deviation", max_deviation,
            "A sample farther than this from the median of its point is an outlier, grey levels. [0, 255]");
    visitor("normal_voxel_m", normal_voxel_m, "Voxels that surface normals are fitted in, metres.");
  }
};

/// Yields the views one after the other, then nothing. Only one is held at a time.
using NextColorView = std::function<std::optional<ColorView>()>;

struct ColorizeResult {
  /// The input's points in the input's order and with its other attributes, `colors` and `num_views` new. A point
  /// that no image shows has num_views 0 and the grey of its intensity (of mid-grey without intensities).
  PointCloud cloud;
  size_t num_images = 0;
  size_t num_colored = 0;  // points with num_views > 0
};

/// Gives every point the robust mean (see ColorSamples) of the colours of the images that really see it. `map` must
/// have been built from `cloud`; a point that it dropped (not finite) is seen by no image.
/// Time is linear in images times points in their frusta; memory is the cloud plus 7 + 4 * max_samples bytes a point.
/// The result does not depend on the number of threads.
ColorizeResult colorize(PointCloud cloud, const VoxelMap& map, const NextColorView& next_view,
                        const ColorizeOptions& options);

}  // namespace cpplus
