#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/trajectory.h"

namespace cpplus {

// Messages of ROS 1 as a bag keeps them. `where` begins the messages of the Error that each throws for bytes that are
// no such message.

struct RosHeader {
  double stamp_s = 0.0;
  std::string frame;
};

struct RosImage {
  RosHeader header;
  ColorImage pixels;
};

struct RosCompressedImage {
  RosHeader header;
  std::string extension;  // ".jpg" or ".png"
  std::string bytes;      // of the file
};

struct RosCloud {
  RosHeader header;
  PointCloud cloud;
};

/// Poses of something (its frame is `child`; "" = not said) in a frame.
struct RosPoses {
  std::string frame;
  std::string child;
  std::vector<StampedPose> poses;
};

struct RosCameraInfo {
  std::string frame;
  Camera camera;
};

struct RosTransform {
  std::string parent;
  std::string child;
  Rigid3 parent_from_child;
};

/// sensor_msgs/Image of 8 bits a channel: rgb8, bgr8, rgba8, bgra8, mono8.
RosImage parse_ros_image(const std::string& where, const uint8_t* data, size_t size);

RosCompressedImage parse_ros_compressed_image(const std::string& where, const uint8_t* data, size_t size);

/// sensor_msgs/PointCloud2 with fields x, y, z; others by the names of point_fields.h. Points that are not finite, or
/// at the origin (what many drivers give for no return), are dropped.
RosCloud parse_ros_point_cloud(const std::string& where, const uint8_t* data, size_t size);

/// livox_ros_driver/CustomMsg; stamps of points are timebase + offset_time.
RosCloud parse_livox_custom(const std::string& where, const uint8_t* data, size_t size);

/// nav_msgs/Odometry: the pose of child_frame in the header's frame.
RosPoses parse_ros_odometry(const std::string& where, const uint8_t* data, size_t size);

/// nav_msgs/Path.
RosPoses parse_ros_path(const std::string& where, const uint8_t* data, size_t size);

/// sensor_msgs/CameraInfo.
RosCameraInfo parse_ros_camera_info(const std::string& where, const uint8_t* data, size_t size);

/// tf2_msgs/TFMessage.
std::vector<RosTransform> parse_ros_transforms(const std::string& where, const uint8_t* data, size_t size);

}  // namespace cpplus
