#include "cpplus/io/file_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/las_header.h"
#include "cpplus/io/pcd.h"
#include "cpplus/io/ply.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/text_parse.h"
#include "cpplus/io/trajectory_io.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

bool has_image_extension(const fs::path& path) {
  constexpr std::string_view kExtensions[] = {".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff"};
  const std::string extension = lower_case(path.extension().string());
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) != std::end(kExtensions);
}

void set_fields(const std::vector<PointField>& fields, FileInfo* info) {
  for (const PointField& field : fields) info->fields.push_back(field.name);
}

FileInfo inspect_cloud(const std::string& path, const std::string& extension) {
  FileInfo info;
  info.kind = FileKind::kPointCloud;
  BlockReader reader(path);
  if (extension == ".pcd") {
    const PcdHeader header = read_pcd_header(&reader);
    constexpr const char* kEncodings[] = {"ascii", "binary", "binary_compressed"};
    info.format = fmt::format("PCD {}", kEncodings[static_cast<size_t>(header.encoding)]);
    info.count = header.num_points;
    set_fields(header.fields, &info);
  } else if (extension == ".ply") {
    const PlyHeader header = read_ply_header(&reader);
    constexpr const char* kEncodings[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    info.format = fmt::format("PLY {}", kEncodings[static_cast<size_t>(header.encoding)]);
    info.count = header.vertices.count;
    set_fields(header.fields, &info);
  } else {
    const LasHeader header = read_las_header(&reader);
    info.format = fmt::format("LAS 1.{}, point format {}", header.version_minor, header.point_format);
    info.count = header.num_points;
    info.extent = Eigen::AlignedBox3d(header.min, header.max);
    set_fields(header.fields, &info);
  }
  return info;
}

FileInfo inspect_model(const std::string& path) {
  const SparseModel model = read_sparse_model(path);
  FileInfo info;
  info.kind = FileKind::kSparseModel;
  info.format = fs::exists(fs::path(path) / "cameras.bin") ? "COLMAP binary" : "COLMAP text";
  info.count = model.images.size();
  info.num_sparse_points = model.points.size();
  for (const auto& [id, camera] : model.cameras) {
    info.cameras.push_back(
        fmt::format("{}: {} {} x {}", id, camera_model_name(camera.model()), camera.width(), camera.height()));
  }
  return info;
}

FileInfo inspect_folder(const std::string& path) {
  FileInfo info;
  info.kind = FileKind::kFolder;
  info.num_images = list_image_files(path).size();
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (!entry.is_regular_file()) continue;
    ++info.count;
    if (!point_cloud_extension(entry.path().string()).empty()) ++info.num_clouds;
  }
  return info;
}

/// A text file is told by its first line that is no comment: eight numbers, or a name and a number.
FileInfo inspect_text(const std::string& path) {
  FileInfo info;
  std::string_view line;
  {
    BlockReader reader(path);
    do {
      if (!reader.take_line(&line)) return info;
      line = trim(line);
    } while (line.empty() || line.front() == '#');
    std::vector<std::string_view> words;
    split_words(line, &words);
    const auto is_number = [](std::string_view word) { return parse_double(word).has_value(); };
    if (words.size() == 8 && std::all_of(words.begin(), words.end(), is_number)) {
      info.kind = FileKind::kTrajectory;
    } else if (words.size() >= 2 && is_number(words.back()) && !is_number(words.front())) {
      info.kind = FileKind::kStamps;
    }
  }
  if (info.kind == FileKind::kTrajectory) {
    const Trajectory trajectory = read_tum(path);
    info.format = "TUM";
    info.count = trajectory.size();
    info.first_stamp_s = trajectory.front().stamp_s;
    info.last_stamp_s = trajectory.back().stamp_s;
  } else if (info.kind == FileKind::kStamps) {
    const auto stamps = read_stamps(path);
    const auto by_stamp = [](const auto& x, const auto& y) { return x.second < y.second; };
    const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end(), by_stamp);
    info.format = "name seconds";
    info.count = stamps.size();
    info.first_stamp_s = first->second;
    info.last_stamp_s = last->second;
  }
  return info;
}

}  // namespace

std::vector<std::string> list_image_files(const std::string& folder) {
  if (!fs::is_directory(folder)) throw Error(fmt::format("{}: no such folder", folder));
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && has_image_extension(entry.path())) {
      files.push_back(entry.path().lexically_relative(folder).generic_string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

FileInfo inspect_file(const std::string& path) {
  if (!fs::exists(path)) throw Error(fmt::format("{}: no such file or folder", path));
  if (fs::is_directory(path)) {
    const bool is_model = fs::exists(fs::path(path) / "cameras.txt") || fs::exists(fs::path(path) / "cameras.bin");
    return is_model ? inspect_model(path) : inspect_folder(path);
  }
  if (const std::string extension = point_cloud_extension(path); !extension.empty()) {
    return inspect_cloud(path, extension);
  }
  if (has_image_extension(path)) {
    FileInfo info;
    info.kind = FileKind::kImage;
    info.format = lower_case(fs::path(path).extension().string().substr(1));
    info.count = 1;
    info.image_size = read_image_size(path);
    return info;
  }
  const std::string extension = lower_case(fs::path(path).extension().string());
  return extension == ".txt" || extension == ".tum" ? inspect_text(path) : FileInfo();
}

}  // namespace cpplus
