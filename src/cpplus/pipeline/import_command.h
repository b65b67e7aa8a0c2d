#pragma once

#include <string>

namespace cpplus {

struct ImportCommandOptions {
  /// colmap, nerfstudio, kitti, kitti-raw, fast-livo2, global-lvba, lio-sam, r3live or rosbag.
  std::string format;
  /// What to import: a folder, nerfstudio's transforms.json, or a bag.
  std::string source;
  /// Folder of the project, which must not exist or be empty.
  std::string out;
  /// It may also hold an earlier import, whose files go; what else is there stays.
  bool replace = false;
  /// Copies images and clouds instead of linking to them.
  bool copy = false;
  /// Taken instead of, or besides, what the source holds; "" = nothing.
  std::string map;
  std::string images;
  std::string trajectory;
  std::string times;
  std::string stamps;
  std::string rig;
  std::string intrinsics;
  /// Topics of a bag; "" = all of images, the only one of clouds (PointCloud2, Livox) and of poses (Odometry, else
  /// Path).
  std::string image_topic;
  std::string lidar_topic;
  std::string pose_topic;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("format", format,
            "colmap, nerfstudio, kitti, kitti-raw, fast-livo2, global-lvba, lio-sam, r3live or rosbag. Required.");
    visitor("source", source, "What to import: a folder, transforms.json or a bag. Required.");
    visitor("out", out, "Folder of the project, new or empty. Required.");
    visitor("replace", replace, "Take the place of an earlier import in that folder.");
    visitor("copy", copy, "Copy images and clouds instead of linking to them.");
    visitor("map", map, "Point cloud to take as the map; empty = the source's.");
    visitor("images", images, "Folder of the images; empty = the source's.");
    visitor("trajectory", trajectory, "Poses of the LiDAR or IMU: TUM, KITTI (with times), csv; empty = the source's.");
    visitor("times", times, "File of one stamp a line for a KITTI trajectory; empty = none.");
    visitor("stamps", stamps, "File with the stamps of the images; empty = the source's.");
    visitor("rig", rig, "Cameras and extrinsics (see poses); empty = the source's.");
    visitor("intrinsics", intrinsics, "Camera of a FAST-LIVO2 rig where it is in a file of its own; empty = none.");
    visitor("image_topic", image_topic, "Topic of a bag with the images; empty = all topics of images.");
    visitor("lidar_topic", lidar_topic, "Topic of a bag with the scans; empty = the only topic of clouds.");
    visitor("pose_topic", pose_topic, "Topic of a bag with odometry or a path; empty = the only one.");
  }
};

struct ImportSummary {
  bool has_map = false;
  size_t num_images = 0;
  size_t num_posed = 0;  // images with a coarse pose
  size_t num_stamps = 0;
  size_t num_trajectory_poses = 0;
  size_t num_scans = 0;
};

/// Brings another program's output into one folder in our conventions (docs/import.md): map.*, scans/ with poses.txt,
/// images/, stamps.txt, trajectory.txt, coarse/ and rig.yaml, each where the source has it, and project.yaml, the
/// options for the commands that go on from there. A new folder appears whole or not at all; one that takes an
/// earlier's place is whole once project.yaml is the new one. Throws Error naming file and
/// value.
ImportSummary import_command(const ImportCommandOptions& options);

}  // namespace cpplus
