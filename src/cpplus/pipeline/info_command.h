#pragma once

#include <string>
#include <vector>

namespace cpplus {

/// Says what a file or folder is, as lines of text: a point cloud, a voxel map (whose checksums are verified), a COLMAP
/// model, a trajectory, stamps, an image, a folder of images, or a scene (a folder that holds such things), with
/// counts, extents and camera models, and for a scene what is missing to refine it. Throws Error for a path that does
/// not exist, is broken, or is none of these.
std::vector<std::string> describe_path(const std::string& path);

}  // namespace cpplus
