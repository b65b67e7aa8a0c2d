#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// The sensor whose poses a trajectory holds. The body is the IMU, or whatever else the rig is described in.
enum class RigFrame { kLidar, kBody };

/// A camera that is fixed to a LiDAR.
struct RigCamera {
  std::string name;
  /// The camera's images are those whose name begins so; "" = every image.
  std::string image_prefix;
  Camera camera;
  std::optional<Rigid3> camera_from_lidar;
  std::optional<Rigid3> camera_from_body;
  /// Added to the stamp of an image, it gives the instant on the trajectory's clock at which its first row was taken.
  double time_offset_s = 0.0;
  /// Time from the first row to the last; 0 = global shutter.
  double readout_s = 0.0;
};

struct Rig {
  std::vector<RigCamera> cameras;
  RigFrame trajectory_frame = RigFrame::kLidar;
};

}  // namespace cpplus
