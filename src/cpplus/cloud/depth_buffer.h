#pragma once

#include <Eigen/Core>

#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"

namespace cpplus {

/// The range of the nearest surface of the map in the directions a camera looks in, on a grid that is coarser than the
/// image and, where wanted, a little larger. Cells are squares of the recorded (distorted) image, so that any camera
/// model works; a range is the distance from the camera centre along the viewing ray, never z.
struct DepthBuffer {
  Camera camera;             // of the full image
  double cell_px = 2.0;      // edge of a cell, image pixels
  int margin_cells = 0;      // rows and columns of cells beyond each border of the image
  bool wraps = false;        // the columns go all the way round (EQUIRECTANGULAR): the last one is next to the first
  double leaf_size_m = 0.0;  // edge of the voxels the surface was drawn from, metres
  RangeImage range;          // metres, per cell; 0 = no surface

  /// The cell that holds an image pixel, or one just outside the grid (see range.contains). Cell (margin_cells,
  /// margin_cells) begins at the top-left corner (-0.5, -0.5) of the image.
  Eigen::Vector2i cell_of(const Eigen::Vector2d& pixel) const;
  /// Image pixel of the centre of a cell.
  Eigen::Vector2d center_of(const Eigen::Vector2i& cell) const;
  /// Column of the grid, the way round where it wraps; -1 outside.
  int column(int x) const;

  /// Range of the surface at an image pixel, metres; 0 where there is none or the pixel is outside the grid.
  float range_at(const Eigen::Vector2d& pixel) const;

  /// The largest range in the cells within `reach` rows and columns of an image pixel's, metres: how far one sees
  /// somewhere near it. +inf where a cell has no surface, 0 where the pixel is outside the grid.
  float farthest_range_near(const Eigen::Vector2d& pixel, int reach = 1) const;

  /// Whether a point is seen: no more than tolerance_m behind the farthest surface in the 3x3 cells around its pixel.
  /// The neighbours absorb the slope of a surface seen at a grazing angle, along which the range changes by more
  /// than any tolerance from cell to cell. False for a point that the camera model cannot project or that falls
  /// outside the grid.
  bool is_visible(const Eigen::Vector3d& x_in_camera, double tolerance_m) const;
};

}  // namespace cpplus
