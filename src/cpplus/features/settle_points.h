#pragma once

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/features/leaf_neighbors.h"

namespace cpplus {

struct SettlePointsOptions {
  double max_distance_sigmas = 3.0;  // a point is on a plane within this many sigmas
  int min_plane_points = 40;         // planes left with fewer are given up
};

/// Planes grow one after the other, and where two meet the first one takes all points within its reach: a strip of the
/// other, as wide as the noise, is missing there. Gives every point of a plane to the one of the planes around it that
/// it is nearest to in sigmas, and fits the planes again. Ids close up where a plane is given up.
void settle_points(const VoxelMap& map, const LeafNeighbors& neighbors, const SettlePointsOptions& options,
                   PlaneSegmentation* planes);

}  // namespace cpplus
