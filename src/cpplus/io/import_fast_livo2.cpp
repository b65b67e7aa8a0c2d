#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/geometry/scaled_camera.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/image_stamps.h"
#include "cpplus/io/import_files.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/pose_file.h"
#include "cpplus/io/rig_formats.h"
#include "cpplus/io/rig_io.h"
#include "cpplus/io/yaml_fields.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

Trajectory read_ordered(const std::string& path) { return order_by_stamp(read_pose_file(path, "")).trajectory; }

/// The pose with the stamp; names and poses carry six decimals.
const StampedPose* pose_at(const Trajectory& trajectory, double stamp_s) {
  constexpr double kRounding = 2e-6;
  const auto earlier = [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; };
  const auto found = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_s - kRounding, earlier);
  return found != trajectory.end() && found->stamp_s <= stamp_s + kRounding ? &*found : nullptr;
}

/// The program resizes images by `scale` and saves them so; the saved image tells.
Camera camera_of_saved_images(const RigCamera& camera, const std::string& image) {
  const ImageSize size = read_image_size(image);
  const double scale = static_cast<double>(size.width) / camera.camera.width();
  if (std::abs(scale * camera.camera.height() - size.height) >= 1.0) {
    throw Error(fmt::format("{}: is {}x{}, its camera {}x{}: no common scale", image, size.width, size.height,
                            camera.camera.width(), camera.camera.height()));
  }
  return scaled_camera(camera.camera, scale);
}

/// The camera on the body. What the program saves has its image stamps corrected already.
Rig read_livo_rig(const std::string& rig, const std::string& intrinsics) {
  if (rig.empty()) throw Error("no rig given: the extrinsics are in FAST-LIVO2's configuration (extrin_calib)");
  Rig read = read_rig(rig, intrinsics);
  if (read.cameras.size() != 1 || !read.cameras[0].camera_from_body) {
    throw Error(fmt::format("{}: must give one camera and where it is on the body", rig));
  }
  read.cameras[0].time_offset_s = 0.0;
  read.trajectory_frame = RigFrame::kBody;
  return read;
}

/// Images named by their stamps, with poses map_from_body at the same stamps.
void add_images(const std::string& folder, const std::string& poses, const Rig& rig, ImportedProject* project) {
  const Trajectory map_from_body = read_ordered(poses);
  std::vector<std::string> names;
  std::vector<Rigid3> camera_from_map;
  size_t num_without_pose = 0;
  for (const SourceFile& image : image_files(folder)) {
    const std::optional<double> stamp = stamp_of_file_name(image.name, StampUnit::kSeconds);
    const StampedPose* pose = stamp ? pose_at(map_from_body, *stamp) : nullptr;
    project->images.push_back(image);
    if (stamp) project->stamps_s[image.name] = *stamp;
    if (!pose) {
      ++num_without_pose;
      continue;
    }
    names.push_back(image.name);
    camera_from_map.push_back(*rig.cameras[0].camera_from_body * inverse(pose->map_from_sensor));
  }
  if (names.empty()) throw Error(fmt::format("{}: has no pose for any image of {}", poses, folder));
  if (num_without_pose > 0) {
    project->notes.push_back(fmt::format("{}: {} of {} images without a pose in {}", folder, num_without_pose,
                                         project->images.size(), poses));
  }
  project->rig = rig;
  project->rig->cameras[0].camera = camera_of_saved_images(rig.cameras[0], project->images.front().path);
  project->model = model_of_images(project->rig->cameras[0].camera, names, camera_from_map);
}

/// Scans in the body's frame, named by their stamps, with poses map_from_body at the same stamps.
void add_scans(const std::string& folder, const Trajectory& map_from_body, ImportedProject* project) {
  size_t num_without_pose = 0;
  for (const std::string& name : files_with_extension(folder, ".pcd")) {
    const std::optional<double> stamp = stamp_of_file_name(name, StampUnit::kSeconds);
    const StampedPose* pose = stamp ? pose_at(map_from_body, *stamp) : nullptr;
    if (!pose) {
      ++num_without_pose;
      continue;
    }
    project->scans.push_back({(fs::path(folder) / name).string(), name});
    project->scan_poses.push_back(*pose);
  }
  if (num_without_pose > 0)
    project->notes.push_back(fmt::format("{}: {} of {} scans without a pose, left out", folder, num_without_pose,
                                         num_without_pose + project->scans.size()));
}

/// pcd_save.type of the configuration: 1 = scans are in the body's frame.
bool scans_are_in_body(const std::string& rig) {
  const YAML::Node save = ros_parameters(load_yaml_map(rig))["pcd_save"];
  return save && save.IsMap() && yaml_number_or(save, "type", 0.0, rig + ": pcd_save") == 1.0;
}

}  // namespace

ImportedProject import_global_lvba(const std::string& folder, const std::string& rig, const std::string& intrinsics) {
  const fs::path root(folder);
  ImportedProject project;
  add_images((root / "all_image").string(), required_file(folder, "all_image/image_poses.txt"),
             read_livo_rig(rig, intrinsics), &project);
  project.trajectory = read_ordered(required_file(folder, "all_pcd_body/lidar_poses.txt"));
  add_scans((root / "all_pcd_body").string(), project.trajectory, &project);
  return project;
}

ImportedProject import_fast_livo2(const std::string& folder, const std::string& rig, const std::string& intrinsics) {
  const fs::path log = fs::is_directory(fs::path(folder) / "Log") ? fs::path(folder) / "Log" : fs::path(folder);
  ImportedProject project;
  const std::string image_poses = first_file(log.string(), {"image/image_poses.txt", "all_image/image_poses.txt"});
  if (!image_poses.empty()) {
    add_images(fs::path(image_poses).parent_path().string(), image_poses, read_livo_rig(rig, intrinsics), &project);
  } else if (fs::is_directory(log / "Colmap" / "sparse" / "0")) {
    project = import_colmap((log / "Colmap").string());
  } else {
    throw Error(fmt::format("{}: neither image/image_poses.txt nor Colmap/sparse/0", log.string()));
  }
  const std::string lidar_poses = first_file(log.string(), {"pcd/lidar_poses.txt", "PCD/lidar_poses.txt"});
  const std::vector<std::string> results = files_with_extension((log / "result").string(), ".txt");
  if (!lidar_poses.empty()) {
    project.trajectory = read_ordered(lidar_poses);
  } else if (results.size() == 1) {
    project.trajectory = read_ordered((log / "result" / results[0]).string());
  } else {
    project.notes.push_back(fmt::format("{}: {} trajectories in result, none taken", log.string(), results.size()));
  }
  project.map = first_file(log.string(), {"pcd/all_raw_points.pcd", "PCD/all_raw_points.pcd",
                                          "pcd/all_downsampled_points.pcd", "PCD/all_downsampled_points.pcd"});
  if (!lidar_poses.empty() && !rig.empty() && scans_are_in_body(rig)) {
    add_scans(fs::path(lidar_poses).parent_path().string(), project.trajectory, &project);
  }
  return project;
}

}  // namespace cpplus
