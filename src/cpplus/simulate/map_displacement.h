#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/simulate/map_fit.h"
#include "cpplus/simulate/simulate.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {

/// The poses that fit the map best, for images of a recording whose scans come one by one: an image looks at the scans
/// of a span of time around it, and keeps a bounded share of what it sees of them.
class MapDisplacement {
 public:
  /// Images in the order of their stamps, with their true poses. The span reaches `reach_s` to both sides.
  MapDisplacement(const Camera& camera, const std::vector<SimulatedImage>& images, double reach_s);

  /// Scans come in the order of their stamps; those that come soon after another one are passed over. The tracer holds
  /// all that the images of the span see.
  void add(const SimulatedScan& scan, const Tracer& tracer);

  /// After the last scan: on_map_camera_from_map of all images.
  std::vector<Rigid3> finish();

 private:
  void fit_images_before(double stamp_s);

  const Camera& camera_;
  std::vector<double> stamps_s_;
  std::vector<Rigid3> truth_;
  double reach_s_;
  double last_scan_s_;
  size_t first_open_ = 0;                            // images before it are fitted
  std::vector<std::vector<DisplacedPoint>> points_;  // of each image; empty once it is fitted
  std::vector<Rigid3> fitted_;
};

}  // namespace cpplus
