#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Points of the map's surface, at most 50 m away, that a camera sees (map frame, metres): one about every 8 pixels of
/// the image, so that a figure averaged over them weighs all parts of the image alike, near or far.
std::vector<Eigen::Vector3d> visible_map_points(const VoxelMap& map, const Camera& camera,
                                                const Rigid3& camera_from_map);

}  // namespace cpplus
