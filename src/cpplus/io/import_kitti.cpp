#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/import_files.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/pose_file.h"
#include "cpplus/io/rotation_check.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

using Matrix34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

/// "NAME: 12 numbers" a line.
std::map<std::string, Matrix34> read_calib(const std::string& path) {
  BlockReader reader(path);
  std::map<std::string, Matrix34> matrices;
  std::vector<std::string_view> words;
  for (std::string_view line; reader.take_line(&line);) {
    split_words(line, &words);
    if (words.empty()) continue;
    const std::string where = fmt::format("{}:{}", path, reader.line_number());
    if (words.size() != 13 || !words[0].ends_with(':')) {
      throw Error(fmt::format("{}: not a name and 12 numbers: {}", where, in_quotes(line)));
    }
    Matrix34 matrix;
    for (int i = 0; i < 12; ++i) {
      const std::optional<double> value = parse_double(words[static_cast<size_t>(i) + 1]);
      if (!value || !std::isfinite(*value)) {
        throw Error(fmt::format("{}: not a finite number: {}", where, in_quotes(words[static_cast<size_t>(i) + 1])));
      }
      matrix(i / 4, i % 4) = *value;
    }
    matrices[std::string(words[0].substr(0, words[0].size() - 1))] = matrix;
  }
  return matrices;
}

const Matrix34& matrix_of(const std::map<std::string, Matrix34>& matrices, const std::string& name,
                          const std::string& path) {
  const auto found = matrices.find(name);
  if (found == matrices.end()) throw Error(fmt::format("{}: has no {}", path, name));
  return found->second;
}

/// The rectified cameras are parallel, so P = K [I | t] with t = camera_from_camera0.
RigCamera rectified_camera(const Matrix34& p, const Matrix34& tr, const std::string& calib, const std::string& image) {
  const ImageSize size = read_image_size(image);
  const Eigen::Matrix3d k = p.leftCols<3>();
  if (k.fullPivLu().rank() < 3) throw Error(fmt::format("{}: P2 has no focal length", calib));
  const Rigid3 camera_from_camera0(Eigen::Quaterniond::Identity(), Eigen::Vector3d(k.inverse() * p.col(3)));
  const Rigid3 camera0_from_lidar(checked_rotation(calib + ": Tr", Eigen::Matrix3d(tr.leftCols<3>())), tr.col(3));
  RigCamera camera;
  camera.name = "image_2";
  camera.camera = Camera(CameraModel::kPinhole, size.width, size.height, {k(0, 0), k(1, 1), k(0, 2), k(1, 2)});
  camera.camera_from_lidar = camera_from_camera0 * camera0_from_lidar;
  return camera;
}

std::string poses_file(const std::string& folder) {
  const fs::path sequence = fs::path(folder).filename().empty() ? fs::path(folder).parent_path() : fs::path(folder);
  const std::string in_dataset = "../../poses/" + sequence.filename().string() + ".txt";
  const std::string found = first_file(sequence.string(), {"poses.txt", in_dataset});
  if (found.empty()) throw Error(fmt::format("{}: neither poses.txt in it nor {}", folder, in_dataset));
  return found;
}

}  // namespace

ImportedProject import_kitti_odometry(const std::string& folder) {
  const std::string calib = required_file(folder, "calib.txt");
  const std::map<std::string, Matrix34> matrices = read_calib(calib);
  ImportedProject project;
  project.images = image_files((fs::path(folder) / "image_2").string());
  const RigCamera camera = rectified_camera(matrix_of(matrices, "P2", calib), matrix_of(matrices, "Tr", calib), calib,
                                            project.images.front().path);
  const Matrix34& tr = matrix_of(matrices, "Tr", calib);
  const Rigid3 camera0_from_lidar(checked_rotation(calib, Eigen::Matrix3d(tr.leftCols<3>())), tr.col(3));

  // Poses are first_camera0_from_camera0; the map shall be the frame of the first scan, whose z axis points up.
  for (const StampedPose& pose : read_pose_file(poses_file(folder), required_file(folder, "times.txt"))) {
    project.trajectory.push_back(
        {pose.stamp_s, inverse(camera0_from_lidar) * pose.map_from_sensor * camera0_from_lidar});
  }
  if (project.images.size() != project.trajectory.size()) {
    throw Error(
        fmt::format("{}: {} images in image_2 for {} poses", folder, project.images.size(), project.trajectory.size()));
  }
  std::vector<std::string> names;
  std::vector<Rigid3> camera_from_map;
  for (size_t i = 0; i < project.images.size(); ++i) {
    names.push_back(project.images[i].name);
    project.stamps_s[names.back()] = project.trajectory[i].stamp_s;
    camera_from_map.push_back(*camera.camera_from_lidar * inverse(project.trajectory[i].map_from_sensor));
  }
  project.model = model_of_images(camera.camera, names, camera_from_map);
  project.rig = Rig{{camera}, RigFrame::kLidar};
  const std::vector<std::string> scans = files_with_extension((fs::path(folder) / "velodyne").string(), ".bin");
  if (scans.size() == project.trajectory.size()) {
    for (const std::string& scan : scans)
      project.scans.push_back({(fs::path(folder) / "velodyne" / scan).string(), scan});
    project.scan_poses = project.trajectory;
  } else {
    project.notes.push_back(fmt::format("{}: {} scans in velodyne for {} poses, left out", folder, scans.size(),
                                        project.trajectory.size()));
  }
  return project;
}

}  // namespace cpplus
