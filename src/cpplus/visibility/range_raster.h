#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/range_raster.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"

namespace cpplus {

/// A point of the map as a camera sees it.
struct ProjectedPoint {
  Eigen::Vector2f pixel;
  float range = 0.0f;       // metres
  float spacing_px = 0.0f;  // between it and its neighbours on the surface
};

/// The points within max_distance_m that project into the image of the plane buffer and belong to a surface (finite
/// spacing), without most of those that its planes hide clearly (hidden_ranges.h). leaf_spacing as leaf_point_spacing()
/// gives it.
std::vector<ProjectedPoint> project_points(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                           const PlaneBuffer& planes, double max_distance_m);

/// Points closed by squares of about their own spacing, so that gaps between them are filled while outlines stay on the
/// outermost points' cells.
RangeRaster draw_range_raster(const std::vector<ProjectedPoint>& points, const Camera& camera, double cell_px);

/// Fills mean_range and num_points: the nearest surface lies in front of the middle of its noise, so that points up to
/// depth_m behind it belong to it.
void add_mean_ranges(const std::vector<ProjectedPoint>& points, double depth_m, RangeRaster* raster);

}  // namespace cpplus
