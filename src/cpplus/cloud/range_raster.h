#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "cpplus/core/image.h"

namespace cpplus {

/// The map's nearest surface on cells of an image, drawn from the points themselves (visibility/range_raster.h).
struct RangeRaster {
  double cell_px = 2.0;
  RangeImage range;       // metres; 0 = no surface
  RangeImage spacing_px;  // of the points the surface was drawn from
  /// Mean range of the cell's own points on that surface, metres, and how many they are. Empty if not asked for.
  RangeImage mean_range;
  Image<uint16_t> num_points;

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

}  // namespace cpplus
