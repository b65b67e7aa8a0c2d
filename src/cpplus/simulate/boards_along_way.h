#pragma once

#include <cstdint>

#include "cpplus/simulate/scene.h"

namespace cpplus {

/// Puts up to `count` checkerboards on tripods beside the way of the LiDAR, as one does before recording a site whose
/// poses are to be judged by them. One after the other stands where it adds most instants of the way at which a camera
/// that looks along the LiDAR's x axis sees a board well (whole, near, not too much from the side); instants that see
/// a board of the scene well count as served. A place has room for the tripod and keeps clear of the LiDAR's way and
/// of those of the moving bodies. Fewer boards where no place adds an instant. The seed chooses tilts and textures.
void add_boards_along_way(int count, uint64_t seed, Scene* scene);

}  // namespace cpplus
