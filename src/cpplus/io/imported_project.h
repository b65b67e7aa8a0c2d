#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/geometry/rig.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/geometry/trajectory.h"

namespace cpplus {

/// A file of the source and its name in the project.
struct SourceFile {
  std::string path;
  std::string name;
};

/// What a reader of another program's output found, in our conventions. Clouds and images stay where they are.
struct ImportedProject {
  /// Point cloud of the map (.pcd, .ply, .las); "" = none.
  std::string map;
  std::vector<SourceFile> images;
  /// Instants of images by their names, on the trajectory's clock unless `rig` has a time offset.
  std::map<std::string, double> stamps_s;
  /// Poses of the LiDAR or body, as rig.trajectory_frame says.
  Trajectory trajectory;
  /// Scans in the frame of the sensor that scan_poses are of, one pose a scan. KITTI's .bin or a point cloud.
  std::vector<SourceFile> scans;
  Trajectory scan_poses;
  std::optional<Rig> rig;
  /// Poses of images where the source has them.
  std::optional<SparseModel> model;
  /// What was found and left out, one line each.
  std::vector<std::string> notes;
};

// Each throws Error naming file and value. docs/import.md has the conventions and where they come from.

/// A folder with a COLMAP model (in itself, sparse/0 or sparse) and images/.
ImportedProject import_colmap(const std::string& folder);

/// A folder with transforms.json, or that file.
ImportedProject import_nerfstudio(const std::string& path);

/// A sequence of KITTI's odometry benchmark: sequences/NN with calib.txt, times.txt, image_2, velodyne, and
/// poses/NN.txt two folders up, or poses.txt in it. The map is the frame of the first scan.
ImportedProject import_kitti_odometry(const std::string& folder);

/// A drive of KITTI's raw data (DATE/DATE_drive_NNNN_sync, the calibration files beside it): oxts, image_02,
/// velodyne_points. The map is the LiDAR's frame at the first instant of oxts.
ImportedProject import_kitti_raw(const std::string& folder);

/// Output of FAST-LIVO2 (its Log folder) or of Global-LVBA's preparation (all_image, all_pcd_body). `rig` is
/// FAST-LIVO2's configuration with the extrinsics, `intrinsics` its camera file ("" = in the rig file).
ImportedProject import_fast_livo2(const std::string& folder, const std::string& rig, const std::string& intrinsics);
ImportedProject import_global_lvba(const std::string& folder, const std::string& rig, const std::string& intrinsics);

/// LIO-SAM's folder of saved clouds: GlobalMap.pcd (or cloudGlobal.pcd) and transformations.pcd.
ImportedProject import_lio_sam(const std::string& folder);

/// R3LIVE's output folder: rgb_pt.pcd. Its offline map (.r3live) is a memory dump and is not read.
ImportedProject import_r3live(const std::string& folder);

/// Topics of a bag to take; "" = all of images, and for the others the only one there is.
struct RosbagTopics {
  std::string images;  // sensor_msgs/Image or CompressedImage
  std::string lidar;   // sensor_msgs/PointCloud2 or Livox CustomMsg
  std::string poses;   // nav_msgs/Odometry or Path
};

/// A ROS 1 bag. Images and scans are written into `folder`, as images/ and scans/; scans only where there are poses.
/// Messages that cannot be read are left out and counted in the notes. `rig` has the cameras of camera_info, with the
/// extrinsics of /tf_static where they are.
ImportedProject import_rosbag(const std::string& bag, const RosbagTopics& topics, const std::string& folder);

}  // namespace cpplus
