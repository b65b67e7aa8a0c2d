#pragma once

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
  void add(std::span<const ProjectedPoint> points);
  RangeRaster finish() &&;

 private:
  RangeRaster raster_;
  Image<RangeKey> nearest_;  // point of each cell
};

RangeRaster draw_range_raster(std::span<const ProjectedPoint> points, const Camera& camera, double cell_px);

/// The points of a view and what is drawn of them.
struct PointsInView {
  std::vector<ProjectedPoint> points;
  RangeRaster raster;
};

/// Projects (projected_points.h) and draws them in one go.
PointsInView points_in_view(const VoxelMap& map, const std::vector<float>& leaf_spacing, const PlaneBuffer& planes,
                            double max_distance_m, double cell_px);

/// Fills mean_range and num_points: the nearest surface lies in front of the middle of its noise, so that points up to
/// depth_m behind it belong to it.
void add_mean_ranges(std::span<const ProjectedPoint> points, double depth_m, RangeRaster* raster);

}  // namespace cpplus
