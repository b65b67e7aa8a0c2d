#pragma once

#include <functional>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {

/// Where the large parts of a district go while it is recorded.
struct DistrictSink {
  /// The points of the next scan, where the map has them; intensity 0..255.
  std::function<void(const PointCloud& points)> scan;
  /// The next image, without on_map_camera_from_map.
  std::function<void(const SimulatedImage& image)> image;
};

/// Records a city district (SimulateOptions::area_km2 and points_million): a LiDAR and a camera travel all its streets,
/// with the tiles around them alone in memory (simulate/district_window.h). Returns the world without what went to the
/// sink and without mesh, edges and checkerboards. The map is every point of every scan; nothing moves. The same
/// options give the same to the last bit, for any number of threads. Throws UsageError for options that do not go
/// together, and what the sink throws.
SimulatedWorld simulate_district(const SimulateOptions& options, const DistrictSink& sink);

}  // namespace cpplus
