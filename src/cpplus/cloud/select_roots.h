#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Roots within max_distance_m of the camera that may meet its field of view, widened by `widening_rad`; ascending.
std::vector<uint32_t> select_roots(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                   double max_distance_m, double widening_rad = 0.0);

}  // namespace cpplus
