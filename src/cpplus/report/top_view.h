#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// The axis of the map (a signed unit vector) that most cameras hold upwards; +z without cameras.
Eigen::Vector3d up_axis(const std::vector<Rigid3>& cameras_from_map);

/// The map looked at from above. `right` and `ahead` are axes of the map with right x ahead = up.
struct TopView {
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitY();

  explicit TopView(const Eigen::Vector3d& up);
  /// Metres along right and ahead, of a position or of a direction.
  Eigen::Vector2d operator*(const Eigen::Vector3d& v) const { return {right.dot(v), ahead.dot(v)}; }
};

/// A rectangle of the top view, metres.
struct TopViewBounds {
  Eigen::Vector2d min = Eigen::Vector2d::Zero();
  Eigen::Vector2d max = Eigen::Vector2d::Zero();
};

/// The rectangle around the positions with at least margin_m and half their extent to each side.
TopViewBounds bounds_around(const std::vector<Eigen::Vector2d>& positions, double margin_m);

/// A floor plan: the more leaves of the map stand over a pixel, the less transparent its grey; walls come out dark. The
/// longer side has at most max_side_px pixels. As the bytes of a PNG with transparency, its top row at max.y.
std::vector<uint8_t> floor_plan_png(const VoxelMap& map, const TopView& view, const TopViewBounds& bounds,
                                    int max_side_px);

}  // namespace cpplus
