#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Gives the points to the planes stated (map order, kNone = none) and fits all planes again. Planes left with fewer
/// than min_plane_points are given up; ids close up.
void refit_planes(const VoxelMap& map, const std::vector<int32_t>& plane_of_point, int min_plane_points,
                  PlaneSegmentation* planes);

}  // namespace cpplus
