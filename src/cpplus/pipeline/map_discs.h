#pragma once

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/render/surface_view.h"

namespace cpplus {

/// A map as discs, for depth and normal maps: the normal of a point is that of its plane instance, else that of its
/// planar voxel of 0.25 m, else not known. Linear in the points.
MapDiscs make_map_discs(const VoxelMap& map);

}  // namespace cpplus
