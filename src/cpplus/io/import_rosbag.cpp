#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/geometry/trajectory_spline.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/ros_messages.h"
#include "cpplus/io/rosbag.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

using Types = std::map<std::string, std::string>;  // of the topics

const std::vector<std::string> kImageTypes = {"sensor_msgs/Image", "sensor_msgs/CompressedImage"};
const std::vector<std::string> kCloudTypes = {"sensor_msgs/PointCloud2", "livox_ros_driver/CustomMsg",
                                              "livox_ros_driver2/CustomMsg"};

bool is_one_of(const std::string& type, const std::vector<std::string>& types) {
  return std::find(types.begin(), types.end(), type) != types.end();
}

std::vector<std::string> topics_of(const Types& types, const std::vector<std::string>& wanted) {
  std::vector<std::string> topics;
  for (const auto& [topic, type] : types) {
    if (is_one_of(type, wanted)) topics.push_back(topic);
  }
  return topics;
}

/// "/left_camera/image" -> "left_camera_image".
std::string file_part(const std::string& topic) {
  std::string part = topic.starts_with("/") ? topic.substr(1) : topic;
  std::replace(part.begin(), part.end(), '/', '_');
  return part;
}

std::string stamp_name(double stamp_s) { return fmt::format("{:.6f}", stamp_s); }

class BagImporter {
 public:
  BagImporter(const std::string& bag, const RosbagTopics& topics, const std::string& folder)
      : bag_(bag), folder_(folder) {
    Types types;
    read_bag(bag, [&](const BagMessage& message) { types[message.topic] = message.type; });
    images_ = topics.images.empty() ? topics_of(types, kImageTypes) : std::vector<std::string>{topics.images};
    lidar_ = choose(types, topics.lidar, kCloudTypes, "clouds");
    const bool has_odometry = !topics_of(types, {"nav_msgs/Odometry"}).empty();
    poses_ = choose(types, topics.poses, {has_odometry ? "nav_msgs/Odometry" : "nav_msgs/Path"}, "poses");
    for (const std::string& topic : {topics.images, topics.lidar, topics.poses}) {
      if (!topic.empty() && types.count(topic) == 0) throw Error(fmt::format("{}: has no topic {}", bag, topic));
    }
  }

  ImportedProject run() {
    read_bag(bag_, [&](const BagMessage& message) { take(message); });
    project_.trajectory = order_by_stamp(poses_read_.poses).trajectory;
    give_scans_poses();
    give_cameras();
    for (const auto& [topic, failures] : failures_) {
      project_.notes.push_back(
          fmt::format("{}: of {} left out: {}, the first: {}", bag_, topic, failures.first, failures.second));
    }
    return std::move(project_);
  }

 private:
  /// The topic that is named, or the only one of the types.
  std::string choose(const Types& types, const std::string& named, const std::vector<std::string>& wanted,
                     const char* what) {
    if (!named.empty()) return named;
    const std::vector<std::string> topics = topics_of(types, wanted);
    if (topics.size() == 1) return topics.front();
    if (topics.size() > 1) {
      project_.notes.push_back(
          fmt::format("{}: {} topics of {}, none taken: {}", bag_, topics.size(), what, fmt::join(topics, ", ")));
    }
    return "";
  }

  void take(const BagMessage& message) {
    const std::string where = fmt::format("{}: {}", bag_, message.topic);
    try {
      if (is_one_of(message.topic, images_)) {
        take_image(where, message);
      } else if (message.topic == lidar_) {
        take_cloud(where, message);
      } else if (message.topic == poses_) {
        take_poses(where, message);
      } else if (message.type == "sensor_msgs/CameraInfo" && cameras_.count(message.topic) == 0) {
        cameras_.insert_or_assign(message.topic, parse_ros_camera_info(where, message.data, message.size));
      }
    } catch (const Error& error) {
      auto& [count, first] = failures_[message.topic];
      if (count++ == 0) first = error.what();
    }
  }

  void take_image(const std::string& where, const BagMessage& message) {
    const std::string sub_folder = images_.size() > 1 ? file_part(message.topic) + "/" : "";
    const auto add = [&](double stamp_s, const char* extension) {
      const std::string name = sub_folder + stamp_name(stamp_s) + extension;
      if (!project_.stamps_s.emplace(name, stamp_s).second)
        throw Error(fmt::format("{}: two images at {} s", where, stamp_s));
      project_.images.push_back({(fs::path(folder_) / "images" / name).string(), name});
      return project_.images.back().path;
    };
    if (message.type == "sensor_msgs/CompressedImage") {
      const RosCompressedImage image = parse_ros_compressed_image(where, message.data, message.size);
      write_text_file(add(image.header.stamp_s, image.extension.c_str()), image.bytes);
    } else {
      const RosImage image = parse_ros_image(where, message.data, message.size);
      write_png(add(image.header.stamp_s, ".png"), image.pixels);
    }
  }

  void take_cloud(const std::string& where, const BagMessage& message) {
    if (poses_.empty()) return;  // scans are of no use without poses
    const RosCloud cloud = message.type == "sensor_msgs/PointCloud2"
                               ? parse_ros_point_cloud(where, message.data, message.size)
                               : parse_livox_custom(where, message.data, message.size);
    if (cloud.cloud.empty()) throw Error(fmt::format("{}: a scan without points at {} s", where, cloud.header.stamp_s));
    lidar_frame_ = cloud.header.frame;
    const std::string name = stamp_name(cloud.header.stamp_s) + ".pcd";
    const std::string path = (fs::path(folder_) / "scans" / name).string();
    write_point_cloud(path, cloud.cloud);
    scans_.emplace_back(cloud.header.stamp_s, SourceFile{path, name});
  }

  void take_poses(const std::string& where, const BagMessage& message) {
    if (message.type == "nav_msgs/Path") {
      poses_read_ = parse_ros_path(where, message.data, message.size);  // a path grows: the last has all of it
      return;
    }
    const RosPoses poses = parse_ros_odometry(where, message.data, message.size);
    poses_read_.frame = poses.frame;
    poses_read_.poses.push_back(poses.poses.front());
  }

  void give_scans_poses() {
    constexpr double kMaxGap = 0.5;  // seconds
    const TrajectorySpline spline(project_.trajectory, kMaxGap);
    const bool is_registered = !scans_.empty() && !lidar_frame_.empty() && lidar_frame_ == poses_read_.frame;
    if (is_registered) {
      project_.notes.push_back(fmt::format("{}: the clouds of {} are in the frame {} of the poses already, left out",
                                           bag_, lidar_, lidar_frame_));
    }
    size_t num_without_pose = 0;
    for (const auto& [stamp_s, file] : scans_) {
      const std::optional<Rigid3> pose = is_registered ? std::nullopt : spline.map_from_sensor(stamp_s);
      if (pose) {
        project_.scans.push_back(file);
        project_.scan_poses.push_back({stamp_s, *pose});
        continue;
      }
      fs::remove(file.path);
      ++num_without_pose;
    }
    if (!is_registered && num_without_pose > 0) {
      project_.notes.push_back(
          fmt::format("{}: {} of {} scans outside the poses, left out", bag_, num_without_pose, scans_.size()));
    }
  }

  /// Cameras without extrinsics: a bag's are in the tree of transforms, if at all.
  void give_cameras() {
    if (cameras_.empty()) return;
    project_.rig.emplace();
    for (const auto& [topic, camera] : cameras_) {
      RigCamera rig_camera;
      rig_camera.name = file_part(topic);
      rig_camera.camera = camera;
      project_.rig->cameras.push_back(rig_camera);
    }
  }

  std::string bag_;
  std::string folder_;
  ImportedProject project_;
  std::vector<std::string> images_;
  std::string lidar_;
  std::string poses_;
  std::string lidar_frame_;
  RosPoses poses_read_;
  std::vector<std::pair<double, SourceFile>> scans_;
  std::map<std::string, Camera> cameras_;
  std::map<std::string, std::pair<size_t, std::string>> failures_;
};

}  // namespace

ImportedProject import_rosbag(const std::string& bag, const RosbagTopics& topics, const std::string& folder) {
  return BagImporter(bag, topics, folder).run();
}

}  // namespace cpplus
