#include "cpplus/pipeline/info_command.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/io/voxel_map_file.h"
#include "cpplus/pipeline/image_folder.h"

namespace cpplus {

namespace fs = std::filesystem;

namespace {

using Lines = std::vector<std::string>;

/// "(1.00, 2.00, 3.00)", never "-0.00".
std::string vector_text(const Eigen::Vector3d& vector) {
  const Eigen::Vector3d rounded = (vector.array() * 100.0).round() / 100.0 + 0.0;
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", rounded.x(), rounded.y(), rounded.z());
}

std::string box_text(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d size = box.sizes();
  return fmt::format("{:.2f} x {:.2f} x {:.2f} m, from {} to {}", size.x(), size.y(), size.z(), vector_text(box.min()),
                     vector_text(box.max()));
}

std::string counted(size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// Names the attributes of a PointCloud or a PointMap.
template <typename Points>
std::string attributes_text(const Points& points) {
  std::string attributes;
  if (!points.intensities.empty()) attributes += " intensity";
  if (!points.colors.empty()) attributes += " colour";
  if (!points.stamps_s.empty()) attributes += " time";
  if (!points.num_views.empty()) attributes += " views";
  if (!points.best_images.empty()) attributes += " best-image";
  if (!points.color_spreads.empty()) attributes += " colour-spread";
  return attributes.empty() ? " none" : attributes;
}

Lines describe_cloud(const std::string& path) {
  ReadCounts counts;
  const PointCloud cloud = read_point_cloud(path, &counts);
  Eigen::AlignedBox3d box;
  for (size_t i = 0; i < cloud.size(); ++i) box.extend(cloud.point(i));
  return {fmt::format("{}: point cloud, {}", path, counted(cloud.size(), "point")),
          fmt::format("  dropped as not finite: {}", counts.dropped_non_finite),
          fmt::format("  extent: {}", box_text(box)), fmt::format("  attributes:{}", attributes_text(cloud))};
}

Lines describe_voxel_map(const std::string& path) {
  verify_voxel_map_file(path);
  const PointMap points = map_voxel_map_file(path);
  const VoxelMap& map = points.map;
  Eigen::AlignedBox3d box;
  for (size_t i = 0; i < map.num_points(); ++i) box.extend(map.point(i));
  return {fmt::format("{}: voxel map, {}, checksums are right", path, counted(map.num_points(), "point")),
          fmt::format("  dropped as not finite: {}", points.num_dropped_non_finite),
          fmt::format("  extent: {}", box_text(box)), fmt::format("  attributes:{}", attributes_text(points)),
          fmt::format("  voxels: {} of {} m, {} of {} m", counted(map.num_nodes(0), "root"), map.options().root_size_m,
                      counted(map.num_nodes(map.leaf_layer()), "leaf voxel"), map.options().leaf_size_m)};
}

bool is_model(const fs::path& folder) {
  return fs::exists(folder / "cameras.txt") || fs::exists(folder / "cameras.bin");
}

Lines describe_model(const std::string& path) {
  const SparseModel model = read_sparse_model(path);
  Eigen::AlignedBox3d centers;
  std::map<uint32_t, size_t> images_of_camera;
  for (const PosedImage& image : model.images) {
    centers.extend(camera_center(image.camera_from_map));
    ++images_of_camera[image.camera_id];
  }
  Lines lines = {fmt::format("{}: COLMAP model, {}, {}, {}", path, counted(model.images.size(), "image"),
                             counted(model.cameras.size(), "camera"), counted(model.points.size(), "point"))};
  for (const auto& [id, camera] : model.cameras) {
    lines.push_back(fmt::format("  camera {}: {} {}x{}, {}", id, camera_model_name(camera.model()), camera.width(),
                                camera.height(), counted(images_of_camera[id], "image")));
  }
  if (!model.images.empty()) lines.push_back(fmt::format("  camera centres: {}", box_text(centers)));
  return lines;
}

Lines describe_images(const std::string& path) {
  const std::vector<std::string> names = list_images(path);
  std::map<std::pair<int, int>, size_t> count_of_size;
  for (const std::string& name : names) {
    const ImageSize size = read_image_size(image_path(path, name));
    ++count_of_size[{size.width, size.height}];
  }
  Lines lines = {fmt::format("{}: folder of {}", path, counted(names.size(), "image"))};
  for (const auto& [size, count] : count_of_size) {
    lines.push_back(fmt::format("  {}x{}: {}", size.first, size.second, counted(count, "image")));
  }
  return lines;
}

Lines describe_trajectory(const std::string& path) {
  const Trajectory trajectory = read_tum(path);
  Eigen::AlignedBox3d box;
  double length_m = 0.0;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    box.extend(trajectory[i].map_from_sensor.translation);
    if (i > 0) {
      length_m += (trajectory[i].map_from_sensor.translation - trajectory[i - 1].map_from_sensor.translation).norm();
    }
  }
  return {fmt::format("{}: trajectory, {}", path, counted(trajectory.size(), "pose")),
          fmt::format("  stamps: {} to {} s, length {:.2f} m", trajectory.front().stamp_s, trajectory.back().stamp_s,
                      length_m),
          fmt::format("  extent: {}", box_text(box))};
}

Lines describe_stamps(const std::string& path) {
  const std::map<std::string, double> stamps = read_stamps(path);
  const auto by_stamp = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end(), by_stamp);
  return {
      fmt::format("{}: stamps of {}, {} to {} s", path, counted(stamps.size(), "image"), first->second, last->second)};
}

/// Whether the first line that is not a comment begins with a number and has more than two values.
bool looks_like_trajectory(const std::string& path) {
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream values(line);
    double number = 0.0;
    std::string second;
    std::string third;
    return static_cast<bool>(values >> number >> second >> third);
  }
  return false;
}

Lines describe_text(const std::string& path) {
  return looks_like_trajectory(path) ? describe_trajectory(path) : describe_stamps(path);
}

Lines describe_file(const std::string& path) {
  if (!point_cloud_extension(path).empty()) return describe_cloud(path);
  if (is_voxel_map_file(path)) return describe_voxel_map(path);
  if (has_image_extension(path)) {
    const ImageSize size = read_image_size(path);
    return {fmt::format("{}: image, {}x{}", path, size.width, size.height)};
  }
  if (fs::path(path).extension() == ".txt") return describe_text(path);
  throw Error(fmt::format("{}: not a kind of file that cpplus reads", path));
}

/// Images in the folder itself, not in folders inside it.
bool holds_images(const std::string& path) {
  const auto is_image = [](const fs::directory_entry& entry) {
    return entry.is_regular_file() && has_image_extension(entry.path().string());
  };
  return std::any_of(fs::directory_iterator(path), fs::directory_iterator(), is_image);
}

enum class SceneEntry { kOther, kMap, kVoxelMap, kImages, kModel, kText };

SceneEntry entry_kind(const fs::path& path) {
  if (!fs::is_directory(path)) {
    if (!point_cloud_extension(path.string()).empty()) return SceneEntry::kMap;
    if (is_voxel_map_file(path.string())) return SceneEntry::kVoxelMap;
    return path.extension() == ".txt" ? SceneEntry::kText : SceneEntry::kOther;
  }
  if (is_model(path)) return SceneEntry::kModel;
  // One folder a camera inside "images" is common.
  const bool nested = path.filename() == "images" && !list_images(path.string()).empty();
  return nested || holds_images(path.string()) ? SceneEntry::kImages : SceneEntry::kOther;
}

Lines describe_entry(const std::string& path, SceneEntry kind) {
  switch (kind) {
    case SceneEntry::kMap:
      return describe_cloud(path);
    case SceneEntry::kVoxelMap:
      return describe_voxel_map(path);
    case SceneEntry::kImages:
      return describe_images(path);
    case SceneEntry::kModel:
      return describe_model(path);
    case SceneEntry::kText:
      try {
        return describe_text(path);
      } catch (const Error&) {
        return {};  // some other text
      }
    case SceneEntry::kOther:
      break;
  }
  return {};
}

/// A folder that holds what others would name on the command line.
Lines describe_scene(const std::string& path) {
  std::vector<fs::path> entries(fs::directory_iterator(path), fs::directory_iterator{});
  std::sort(entries.begin(), entries.end());
  Lines lines;
  std::set<SceneEntry> found;
  for (const fs::path& entry : entries) {
    const SceneEntry kind = entry_kind(entry);
    found.insert(kind);
    for (const std::string& line : describe_entry(entry.string(), kind)) lines.push_back("  " + line);
  }
  if (lines.empty()) throw Error(fmt::format("{}: folder without images, point clouds or a COLMAP model", path));
  Lines missing;
  if (found.count(SceneEntry::kMap) + found.count(SceneEntry::kVoxelMap) == 0)
    missing.push_back("a map (.pcd .ply .las)");
  if (found.count(SceneEntry::kImages) == 0) missing.push_back("a folder of images");
  if (found.count(SceneEntry::kModel) == 0) missing.push_back("a COLMAP model");
  lines.insert(lines.begin(), fmt::format("{}: scene", path));
  lines.push_back(missing.empty() ? "  nothing is missing to refine it"
                                  : fmt::format("  missing to refine it: {}", fmt::join(missing, ", ")));
  return lines;
}

}  // namespace

Lines describe_path(const std::string& path) {
  if (!fs::exists(path)) throw Error(fmt::format("{}: no such file or folder", path));
  if (!fs::is_directory(path)) return describe_file(path);
  if (is_model(path)) return describe_model(path);
  if (holds_images(path)) return describe_images(path);
  return describe_scene(path);
}

}  // namespace cpplus
