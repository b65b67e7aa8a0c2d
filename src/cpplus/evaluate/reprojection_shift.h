#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Distances along the viewing rays, known on a regular grid of pixels of the recorded (distorted) image.
/// Column i, row j belong to pixel first_pixel + step_px * (i, j).
struct RangeGrid {
  RangeImage ranges;                                      // metres; 0 or not finite = nothing there
  double step_px = 1.0;                                   // (0, inf)
  Eigen::Vector2d first_pixel = Eigen::Vector2d::Zero();  // centre of the top-left pixel = (0, 0)
};

/// The surface points that a range grid shows, map frame, metres, in row-major order of the grid. Elements without a
/// range and pixels that the camera model cannot unproject give no point.
std::vector<Eigen::Vector3d> visible_points_from_ranges(const RangeGrid& grid, const Camera& camera,
                                                        const Rigid3& camera_from_map);

/// By how many pixels the visible surface moves in the image when the estimated pose is taken for the reference.
struct ReprojectionShift {
  size_t num_points = 0;  // points that the reference pose projects; 0 makes the figures NaN
  size_t num_lost = 0;    // of these, the ones that the estimate does not project at all (behind it, for example)
  double mean_px;
  double median_px;
  double max_px;
};

/// Compares the pixels of the same points under both poses. Points (map frame, metres) that the reference does not
/// project are left out. The shift of one point is capped at the image diagonal, and a point that the estimate does
/// not project counts with this cap: a camera turned away gets a large finite figure instead of a good one from the
/// few points left. For EQUIRECTANGULAR the shift is measured across the left-right seam where that is shorter.
ReprojectionShift reprojection_shift(const std::vector<Eigen::Vector3d>& points_in_map, const Camera& camera,
                                     const Rigid3& estimate_camera_from_map, const Rigid3& reference_camera_from_map);

}  // namespace cpplus
