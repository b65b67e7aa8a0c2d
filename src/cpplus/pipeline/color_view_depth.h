#pragma once

#include "cpplus/cloud/depth_buffer.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// What the map hides from an image that gives colours or is compared with them: cells of 2 px. Finer ones leave gaps
/// between the leaves of near surfaces, coarser ones blur the edges that colours must not cross.
DepthBuffer color_view_depth(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                             double max_distance_m);

}  // namespace cpplus
