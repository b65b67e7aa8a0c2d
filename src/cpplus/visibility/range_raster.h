#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A point of the map as a camera sees it.
struct ProjectedPoint {
  Eigen::Vector2f pixel;
  float range = 0.0f;       // metres
  float spacing_px = 0.0f;  // between it and its neighbours on the surface
};

/// The points within max_distance_m that project into the image and belong to a surface (finite spacing), whatever
/// hides them. leaf_spacing as leaf_point_spacing() gives it.
std::vector<ProjectedPoint> project_points(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                           const Camera& camera, const Rigid3& camera_from_map, double max_distance_m);

/// The map's nearest surface on cells of the image: the points closed by squares of about their own spacing, so that
/// gaps between them are filled while outlines stay on the outermost points' cells.
struct RangeRaster {
  double cell_px = 2.0;
  RangeImage range;       // metres; 0 = no surface
  RangeImage spacing_px;  // of the points the surface was drawn from

  float range_at(const Eigen::Vector2i& cell) const {
    return range.contains(cell.x(), cell.y()) ? range.at(cell.x(), cell.y()) : 0.0f;
  }
  /// Of a pixel of the image; left of and above it the first cell.
  Eigen::Vector2i cell_of(const Eigen::Vector2f& pixel) const {
    const float inverse_cell = 1.0f / static_cast<float>(cell_px);
    return {static_cast<int>((pixel.x() + 0.5f) * inverse_cell), static_cast<int>((pixel.y() + 0.5f) * inverse_cell)};
  }
  /// Image pixel of the top-left corner of a cell.
  Eigen::Vector2d corner_of(const Eigen::Vector2i& cell) const {
    return (cell.cast<double>().array() * cell_px - 0.5).matrix();
  }
};

RangeRaster draw_range_raster(const std::vector<ProjectedPoint>& points, const Camera& camera, double cell_px);

}  // namespace cpplus
