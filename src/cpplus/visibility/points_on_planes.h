#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// A point of the map in an image.
struct PointInView {
  uint32_t index = 0;  // in the order of the map
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
};

/// The points within max_distance_m that a camera sees, as far as they lie on planes: those no more than margin_m from
/// the plane that the buffer shows at their pixel. What moved through the scan has no planes there, so it neither
/// counts nor hides. In the order of the map. leaf_spacing as leaf_point_spacing() gives it.
std::vector<PointInView> points_on_seen_planes(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                               const PlaneBuffer& planes, double max_distance_m, double margin_m);

}  // namespace cpplus
