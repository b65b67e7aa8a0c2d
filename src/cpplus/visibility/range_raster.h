#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/cloud/range_raster.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/visibility/projected_points.h"
#include "cpplus/visibility/range_keys.h"

namespace cpplus {

/// Draws points closed by squares of about their own spacing, so that gaps between them are filled while outlines stay
/// on the outermost points' cells.
class RangeRasterDrawer {
 public:
  RangeRasterDrawer(const Camera& camera, double cell_px);
  /// Points in the image. Index in the raster of the cell of each goes to `cells`.
  void add(std::span<const ProjectedPoint> points, uint32_t* cells);
  RangeRaster finish() &&;

 private:
  RangeRaster raster_;
  Image<RangeKey> nearest_;  // point of each cell
};

/// The points of a view and what is drawn of them.
struct PointsInView {
  std::vector<ProjectedPoint> points;
  std::vector<uint32_t> cells;  // of each point the index of its cell in the raster
  RangeRaster raster;
};

/// Projects (projected_points.h) and draws them in one go.
PointsInView points_in_view(const VoxelMap& map, const std::vector<float>& leaf_spacing, const PlaneBuffer& planes,
                            double max_distance_m, double cell_px);

/// Fills the raster's points: all of the view. noise_m: their standard deviation about the surface.
void add_points_by_cell(double noise_m, PointsInView* view);

}  // namespace cpplus
