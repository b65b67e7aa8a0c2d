#pragma once

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/features/leaf_neighbors.h"

namespace cpplus {

/// Where the noise across a surface is larger than the map's usual noise (walls see all of the range noise, floors only
/// the part across them) growth splits the surface into parallel layers: a middle one and its tails. Joins planes that
/// lie over each other when the points of both, counted by their distance, have one mode; the faces of a board have two
/// and stay apart. Then every point is settled again (settle_points).
void merge_layers(const VoxelMap& map, const LeafNeighbors& neighbors, PlaneSegmentation* planes);

}  // namespace cpplus
