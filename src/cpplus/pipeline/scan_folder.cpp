#include "cpplus/pipeline/scan_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/trajectory_io.h"

namespace cpplus {

namespace fs = std::filesystem;

namespace {

/// As a cloud read from a file: local maps keep the origin 0, georeferenced ones get one nearby.
Eigen::Vector3d map_origin(const Trajectory& poses) {
  constexpr double kLocalCoordinate = 1000.0;
  const Eigen::Vector3d& first = poses.front().map_from_sensor.translation;
  return first.unaryExpr([](double c) { return std::abs(c) < kLocalCoordinate ? 0.0 : std::round(c); });
}

void move_to_map(const Rigid3& map_from_lidar, const Eigen::Vector3d& origin, PointCloud* scan) {
  const Eigen::Matrix3d rotation = map_from_lidar.rotation.toRotationMatrix();
  const Eigen::Vector3d offset = map_from_lidar.translation - origin;
  for (size_t i = 0; i < scan->size(); ++i) {
    scan->positions[i] = (rotation * scan->point(i) + offset).cast<float>();
  }
  scan->origin = origin;
}

/// Joins one attribute of the scans, which lose it as it goes: it is never held twice. Empty where a scan does not have
/// it.
template <typename T>
std::vector<T> take_joined(std::vector<PointCloud>* scans, std::vector<T> PointCloud::*attribute) {
  std::vector<T> all;
  const bool is_everywhere =
      std::none_of(scans->begin(), scans->end(), [&](const PointCloud& scan) { return (scan.*attribute).empty(); });
  size_t size = 0;
  for (const PointCloud& scan : *scans) size += (scan.*attribute).size();
  if (is_everywhere) all.reserve(size);
  for (PointCloud& scan : *scans) {
    const std::vector<T> taken = std::move(scan.*attribute);
    if (is_everywhere) all.insert(all.end(), taken.begin(), taken.end());
  }
  return all;
}

}  // namespace

std::vector<std::string> list_scans(const std::string& directory) {
  if (!fs::is_directory(directory)) throw Error(fmt::format("{}: not a folder of scans", directory));
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
    const std::string path = entry.path().string();
    if (entry.is_regular_file() && !point_cloud_extension(path).empty()) files.push_back(path);
  }
  if (files.empty()) throw Error(fmt::format("{}: holds no scan (.pcd .ply .las)", directory));
  std::sort(files.begin(), files.end());
  return files;
}

ScanFolder read_scan_folder(const std::string& directory, const std::string& poses) {
  ScanFolder folder;
  folder.files = list_scans(directory);
  folder.map_from_lidar = read_tum(poses);
  const Trajectory& map_from_lidar = folder.map_from_lidar;
  if (map_from_lidar.size() != folder.files.size()) {
    throw Error(fmt::format("{}: {} poses for the {} scans in {}", poses, map_from_lidar.size(), folder.files.size(),
                            directory));
  }
  folder.dropped_points.resize(folder.files.size());
  const Eigen::Vector3d origin = map_origin(map_from_lidar);
  std::vector<PointCloud> scans(folder.files.size());
  Progress progress("read scans", scans.size());
  std::vector<std::exception_ptr> errors(scans.size());  // of several broken scans the first is named
  parallel_for_each(scans.size(), [&](size_t i) {
    try {
      ReadCounts counts;
      scans[i] = read_point_cloud(folder.files[i], &counts);
      move_to_map(map_from_lidar[i].map_from_sensor, origin, &scans[i]);
      folder.dropped_points[i] = std::move(counts.dropped_points);
    } catch (const Error&) {
      errors[i] = std::current_exception();
    }
    progress.advance();
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  for (size_t i = 0; i < scans.size(); ++i) {
    folder.scans.first_point.push_back(folder.scans.first_point.back() + scans[i].size());
    folder.scans.sensors_in_map.push_back(map_from_lidar[i].map_from_sensor.translation);
  }
  PointCloud& points = folder.scans.points;
  points.origin = origin;
  points.positions = take_joined(&scans, &PointCloud::positions);
  points.intensities = take_joined(&scans, &PointCloud::intensities);
  points.colors = take_joined(&scans, &PointCloud::colors);
  points.stamps_s = take_joined(&scans, &PointCloud::stamps_s);
  return_freed_memory();  // the clouds of single scans
  return folder;
}

void write_label_files(const std::string& directory, const ScanFolder& folder, const std::vector<uint8_t>& labels) {
  for (size_t scan = 0; scan < folder.files.size(); ++scan) {
    const std::vector<size_t>& dropped = folder.dropped_points[scan];
    const size_t begin = folder.scans.first_point[scan];
    const size_t in_file = folder.scans.first_point[scan + 1] - begin + dropped.size();
    std::string bytes(in_file, '\0');
    size_t next_dropped = 0;
    for (size_t i = 0; i < in_file; ++i) {
      if (next_dropped < dropped.size() && dropped[next_dropped] == i) {
        ++next_dropped;
        continue;
      }
      bytes[i] = static_cast<char>(labels[begin + i - next_dropped]);
    }
    write_text_file(fmt::format("{}/{}.label", directory, fs::path(folder.files[scan]).stem().string()), bytes);
  }
}

}  // namespace cpplus
