#pragma once

#include <string>
#include <vector>

#include "cpplus/evaluate/checkerboard_residual.h"

namespace cpplus {

/// Reads a file {"boards": [{"name", "corners_3d": [[x, y, z], …], "images": {NAME: {"corners_2d": [[x, y], …]}}}]}
/// with pixels in COLMAP's convention (centre of the top-left pixel = (0.5, 0.5)), which is turned into ours.
/// Throws Error naming the file, and the board where the fault is inside one.
std::vector<Checkerboard> read_checkerboards(const std::string& path);

}  // namespace cpplus
