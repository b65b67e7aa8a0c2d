#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/range_raster.h"
#include "cpplus/geometry/camera.h"

namespace cpplus {

/// A point of the map as a camera sees it.
struct SeenPoint {
  Eigen::Vector3d bearing;  // unit vector, camera frame
  double range = 0.0;       // metres
  double nearest = 0.0;     // range of what the raster shows in its cell: a nearer point may hide it
  uint32_t cell = 0;        // its cell of the raster, numbered among those below that hold points
};

/// The points around a pixel.
struct SeenSquare {
  std::vector<SeenPoint> points;
  size_t num_cells = 0;       // that hold points
  double share_filled = 0.0;  // of all its cells: those in which the raster shows a surface
};

/// The points in the cells of a square of half edge radius_px around a pixel. Bearings are taken to be linear in the
/// pixel there. Empty where the pixel has no bearing.
SeenSquare points_around(const Camera& camera, const RangeRaster& raster, const Eigen::Vector2d& pixel,
                         double radius_px);

}  // namespace cpplus
