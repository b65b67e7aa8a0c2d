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

/// Frames that are fixed to each other.
class FrameTree {
 public:
  void add(const std::vector<RosTransform>& transforms) {
    for (const RosTransform& transform : transforms) {
      neighbours_[transform.parent][transform.child] = transform.parent_from_child;
      neighbours_[transform.child][transform.parent] = inverse(transform.parent_from_child);
    }
  }

  /// a_from_b, over as many frames between as it takes; nothing where they are not connected.
  std::optional<Rigid3> find(const std::string& a, const std::string& b) const {
    if (a.empty() || b.empty()) return {};
    std::map<std::string, Rigid3> a_from = {{a, Rigid3{}}};
    std::vector<std::string> to_visit = {a};
    for (size_t i = 0; i < to_visit.size() && a_from.count(b) == 0; ++i) {
      const auto neighbours = neighbours_.find(to_visit[i]);
      if (neighbours == neighbours_.end()) continue;
      for (const auto& [frame, this_from_frame] : neighbours->second) {
        if (!a_from.emplace(frame, a_from.at(neighbours->first) * this_from_frame).second) continue;
        to_visit.push_back(frame);
      }
    }
    const auto found = a_from.find(b);
    return found == a_from.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::map<std::string, std::map<std::string, Rigid3>> neighbours_;
};

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
      } else if (message.topic == "/tf_static") {
        frames_.add(parse_ros_transforms(where, message.data, message.size));
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
    poses_read_.child = poses.child;
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
    // Where the tree of transforms does not say it, the poses are taken for the LiDAR's own.
    const Rigid3 sensor_from_lidar = frames_.find(poses_read_.child, lidar_frame_).value_or(Rigid3{});
    size_t num_without_pose = 0;
    for (const auto& [stamp_s, file] : scans_) {
      const std::optional<Rigid3> pose = is_registered ? std::nullopt : spline.map_from_sensor(stamp_s);
      if (pose) {
        project_.scans.push_back(file);
        project_.scan_poses.push_back({stamp_s, *pose * sensor_from_lidar});
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

  /// The cameras of camera_info, with the extrinsics that /tf_static gives: on what the poses are of (the body), and on
  /// the LiDAR.
  void give_cameras() {
    Rig rig;
    bool all_on_body = true;
    for (const auto& [topic, info] : cameras_) {
      const std::optional<std::string> images = images_beside(topic);
      if (!images && cameras_.size() > 1) continue;  // no images are taken of this one
      RigCamera camera;
      camera.name = file_part(topic);
      camera.camera = info.camera;
      if (images && images_.size() > 1) camera.image_prefix = file_part(*images) + "/";
      camera.camera_from_body = frames_.find(info.frame, poses_read_.child);
      camera.camera_from_lidar = frames_.find(info.frame, lidar_frame_);
      all_on_body = all_on_body && camera.camera_from_body;
      rig.cameras.push_back(camera);
    }
    if (rig.cameras.empty()) return;
    rig.trajectory_frame = all_on_body ? RigFrame::kBody : RigFrame::kLidar;
    project_.rig = rig;
  }

  /// The topic of images in the same name space as one of camera_info: "/left/image_raw/compressed" for
  /// "/left/camera_info".
  std::optional<std::string> images_beside(const std::string& camera_topic) const {
    const std::string name_space = camera_topic.substr(0, camera_topic.find_last_of('/') + 1);
    for (const std::string& topic : images_) {
      if (topic.starts_with(name_space)) return topic;
    }
    return {};
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
  std::map<std::string, RosCameraInfo> cameras_;
  FrameTree frames_;
  std::map<std::string, std::pair<size_t, std::string>> failures_;
};

}  // namespace

ImportedProject import_rosbag(const std::string& bag, const RosbagTopics& topics, const std::string& folder) {
  return BagImporter(bag, topics, folder).run();
}

}  // namespace cpplus
