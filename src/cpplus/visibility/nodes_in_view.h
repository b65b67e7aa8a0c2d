#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/visibility/hidden_ranges.h"

namespace cpplus {

/// The nodes of a layer of which a part, or what reaches margin_m beyond them, may lie in the image within
/// max_distance_m of the camera and is not hidden, ascending. A superset: nodes are tested by their circumscribed
/// spheres. From the roots downwards, so that what is not in view costs little.
std::vector<uint32_t> nodes_in_view(const VoxelMap& map, int layer, const Camera& camera, const Rigid3& camera_from_map,
                                    double max_distance_m, double margin_m, const HiddenRanges& hidden);

}  // namespace cpplus
