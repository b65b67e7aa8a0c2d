#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// One image of a nerfstudio data set.
struct NerfstudioFrame {
  std::string image_path;  // relative to transforms.json, as all paths
  std::string depth_path;  // 16-bit PNG; "" = none
  Camera camera;           // PINHOLE
  Rigid3 camera_from_map;
};

/// Writes transforms.json. transform_matrix is map_from_camera for a camera with x right, y up and z backward
/// (OpenGL), that is ours turned by half a turn about x; the map is the world, unchanged. The principal point is in
/// COLMAP's pixels, 0.5 larger than ours. Intrinsics stand at the top where all frames share them, else in each frame.
/// `ply_path`: sparse points; "" = none. Throws Error where the file cannot be written, and for a camera that is not
/// PINHOLE.
void write_nerfstudio(const std::string& path, const std::vector<NerfstudioFrame>& frames, const std::string& ply_path);

}  // namespace cpplus
