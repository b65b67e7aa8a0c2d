#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/rig.h"

namespace YAML {
class Node;
}

namespace cpplus {

// The parts of read_rig and read_intrinsics, one a format. Pixels in all but our own are OpenCV's, hence ours: the
// centre of the top-left pixel is (0, 0).

Rig own_rig(const YAML::Node& root, const std::string& path);
Rig kalibr_rig(const YAML::Node& root, const std::string& path);
Rig r3live_rig(const YAML::Node& root, const std::string& path);
Rig fast_livo2_rig(const YAML::Node& root, const std::string& path, const std::string& intrinsics);

/// The parameters inside ROS 2's "/node: ros__parameters:"; other files as they are.
YAML::Node ros_parameters(const YAML::Node& root);

bool is_fast_livo2_camera(const YAML::Node& root);
Camera fast_livo2_camera(const YAML::Node& root, const std::string& path);
Camera kalibr_camera(const YAML::Node& node, const std::string& where);
Camera ros_camera_info(const YAML::Node& root, const std::string& path);
/// The fields of sensor_msgs/CameraInfo; matrix = the nine numbers of K.
Camera ros_camera(const std::string& where, int width, int height, const std::string& distortion_model,
                  const std::vector<double>& matrix, const std::vector<double>& distortion);

/// focal = fx fy cx cy; distortion = OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6]], the shortest model that holds it.
Camera opencv_camera(const std::string& where, int width, int height, const std::vector<double>& focal,
                     std::vector<double> distortion);
/// distortion = OpenCV's fisheye k1 k2 k3 k4.
Camera fisheye_camera(const std::string& where, int width, int height, const std::vector<double>& focal,
                      const std::vector<double>& distortion);

}  // namespace cpplus
