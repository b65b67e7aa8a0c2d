#pragma once

#include <Eigen/Core>
#include <optional>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// A plane as it is near a piece of a line that it meets another plane in.
struct LocalPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // unit, map frame
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  // map frame, metres
  double offset_variance = 0.0;                        // of the plane's distance at the line, square metres
};

struct LinePiece {
  Eigen::Vector3d middle;     // map frame, metres
  Eigen::Vector3d direction;  // unit
  double length = 0.0;        // metres
};

/// Fits plane `id` to its points up to fit_distance_m from the piece, without those within the noise of plane `other`:
/// they may be the other's, and mixed pixels round a corner.
///
/// The third of the points that is nearest to the line must agree with the fit in offset and slope. Where it does not
/// (a frame on a wall, a skirting board), only half the distance is used; nothing when it does not agree then either:
/// the surface is curved, or none. `nullopt` as well when its residuals are far above the noise of the map.
std::optional<LocalPlane> fit_local_plane(const VoxelMap& map, const PlaneSegmentation& planes, int32_t id,
                                          int32_t other, const LinePiece& piece, double fit_distance_m);

}  // namespace cpplus
