#pragma once

#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// The mean distance between neighbouring points on the surface in each leaf of a map, metres: the edge of the cells
/// that hold 2.5 points each, in surroundings of 75 cm. It is sqrt(area / points) where cells of that size are
/// large enough to leave no gaps in the surface; smaller ones would count points instead of area. +inf where the
/// surroundings have too few points to be a surface. Linear in the leaves.
std::vector<float> leaf_point_spacing(const VoxelMap& map);

/// The layer whose nodes each have one spacing in all their leaves. The map must not be empty.
int point_spacing_layer(const VoxelMap& map);

}  // namespace cpplus
