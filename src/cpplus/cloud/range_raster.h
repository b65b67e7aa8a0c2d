#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// The points of a view by the cell of its raster that they lie in.
struct PointsByCell {
  struct Point {
    Eigen::Vector2f pixel;
    float range = 0.0f;  // metres
  };
  std::vector<uint32_t> begin;  // of each cell, row by row, then the end of the last; empty where there are no points
  std::vector<Point> points;
  double noise_m = 0.0;  // standard deviation of a point about its surface
};

/// The map's nearest surface on cells of an image, drawn from the points themselves (visibility/range_raster.h).
struct RangeRaster {
  double cell_px = 2.0;
  RangeImage range;       // metres; 0 = no surface
  RangeImage spacing_px;  // of the points the surface was drawn from
  PointsByCell points;    // hidden ones too; empty if not asked for

  float range_at(const Eigen::Vector2i& cell) const {
    return range.contains(cell.x(), cell.y()) ? range.at(cell.x(), cell.y()) : 0.0f;
  }
  std::span<const PointsByCell::Point> points_in(const Eigen::Vector2i& cell) const {
    if (points.begin.empty() || !range.contains(cell.x(), cell.y())) return {};
    const size_t at = static_cast<size_t>(cell.y()) * static_cast<size_t>(range.width) + static_cast<size_t>(cell.x());
    return {points.points.data() + points.begin[at], points.points.data() + points.begin[at + 1]};
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

}  // namespace cpplus
