#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Which nodes lie on an extended surface, rather than on a body that is small on its own: what people leave in a map
/// as they walk by, specks, mixed pixels, thin plants. A map that nobody cleaned is full of such bodies, they stand
/// anywhere, close to the camera too, and each would hide a large part of the view.
///
/// A node's surroundings are the 3x3x3 nodes around it. In them the means of the occupied leaves spread over an area
/// when their second largest standard deviation is at least min_extent times the 3 a / sqrt(12) of a plane across the
/// cube (a = edge of a node); the measure does not depend on how dense the leaves are. Nodes that share a face with
/// such a node belong to the surface as well, since at its border half of the cube is empty.
///
/// roots: ascending. Returns a flag per node of `layer`, for the nodes of roots[0], roots[1], … one after the other.
/// Leaves of other roots count as empty. Linear in the leaves.
std::vector<uint8_t> find_extended_nodes(const VoxelMap& map, const std::vector<uint32_t>& roots, int layer,
                                         double min_extent);

}  // namespace cpplus
