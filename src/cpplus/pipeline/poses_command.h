#pragma once

#include <string>

namespace cpplus {

struct PosesCommandOptions {
  /// Poses of the LiDAR or IMU in the map: TUM, KITTI (with `times`) or csv.
  std::string trajectory;
  /// File of one stamp a line for a KITTI trajectory; "" = none.
  std::string times;
  /// Cameras and extrinsics: rig.yaml, Kalibr, R3LIVE or FAST-LIVO2.
  std::string rig;
  /// The camera of a FAST-LIVO2 rig where a file of its own holds it; "" = none.
  std::string intrinsics;
  /// Folder of the images.
  std::string images;
  /// Folder for the COLMAP text model and stamps.txt.
  std::string out;
  /// File with the stamps of the images; "" = their names hold them.
  std::string stamps;
  /// Unit of stamps that are whole numbers: auto, s, ms, us or ns.
  std::string stamp_unit = "auto";
  /// What the trajectory's poses are of: lidar, body, or "" = what the rig says.
  std::string trajectory_frame;
  /// Poses farther apart than this are not connected: images between them get no pose. s, (0, inf)
  double max_gap_s = 0.5;
  /// Size of the images relative to what the rig says; intrinsics are scaled. (0, 100]
  double image_scale = 1.0;
  /// The map's upward axis, by which a wrong extrinsic is noticed: x, -x, y, -y, z, -z or none.
  std::string up = "z";

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("trajectory", trajectory,
            "Poses of the LiDAR or IMU in the map: TUM, KITTI (with times) or csv. Required.");
    visitor("times", times, "File of one stamp a line for a KITTI trajectory; empty = none.");
    visitor("rig", rig, "Cameras and extrinsics: rig.yaml, Kalibr, R3LIVE or FAST-LIVO2. Required.");
    visitor("intrinsics", intrinsics, "Camera of a FAST-LIVO2 rig where it is in a file of its own; empty = none.");
    visitor("images", images, "Folder of the images. Required.");
    visitor("out", out, "Folder for the model with the coarse poses and stamps.txt. Required.");
    visitor("stamps", stamps, "File with the stamps of the images, NAME SECONDS a line or csv; empty = their names.");
    visitor("stamp_unit", stamp_unit, "Unit of stamps that are whole numbers: auto, s, ms, us or ns.");
    visitor("trajectory_frame", trajectory_frame, "What the trajectory is of: lidar or body; empty = as the rig says.");
    visitor("max_gap_s", max_gap_s, "Images between trajectory poses farther apart get no pose, s. (0, inf)");
    visitor("image_scale", image_scale, "Size of the images relative to the rig's; scales the intrinsics. (0, 100]");
    visitor("up", up, "The map's upward axis, to notice a wrong extrinsic: x, -x, y, -y, z, -z or none.");
  }
};

struct PosesSummary {
  size_t num_images = 0;
  size_t num_posed = 0;
  size_t num_outside = 0;  // before or after the trajectory
  size_t num_in_gap = 0;
  size_t num_without_stamp = 0;
  size_t num_double_stamp = 0;
  size_t num_without_camera = 0;
};

/// Gives each image the pose that trajectory and extrinsic say it was taken from, at its stamp plus the camera's time
/// offset plus half its readout, and writes OUT/{cameras,images,points3D}.txt and OUT/stamps.txt (those instants).
/// Images that get none are named and counted in warnings. Throws Error naming the file for bad input, and when no
/// image gets a pose.
PosesSummary poses_command(const PosesCommandOptions& options);

}  // namespace cpplus
