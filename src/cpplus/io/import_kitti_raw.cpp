#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/geometry/trajectory_spline.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/import_files.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/rotation_check.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

std::string first_line(const std::string& path) {
  BlockReader reader(path);
  std::string_view line;
  if (!reader.take_line(&line)) throw Error(fmt::format("{}: is empty", path));
  return std::string(line);
}

std::vector<double> numbers_of(const std::string& where, std::string_view text, size_t least) {
  std::vector<std::string_view> words;
  split_words(text, &words);
  std::vector<double> numbers;
  for (const std::string_view word : words) {
    const std::optional<double> value = parse_double(word);
    if (!value || !std::isfinite(*value))
      throw Error(fmt::format("{}: not a finite number: {}", where, in_quotes(word)));
    numbers.push_back(*value);
  }
  if (numbers.size() < least) throw Error(fmt::format("{}: {} numbers instead of {}", where, numbers.size(), least));
  return numbers;
}

/// The numbers after "NAME:" in a calibration file.
std::vector<double> calib_numbers(const std::string& path, const std::string& name, size_t count) {
  BlockReader reader(path);
  for (std::string_view line; reader.take_line(&line);) {
    if (!line.starts_with(name + ":")) continue;
    return numbers_of(fmt::format("{}:{}", path, reader.line_number()), line.substr(name.size() + 1), count);
  }
  throw Error(fmt::format("{}: has no {}", path, name));
}

Eigen::Matrix3d rows_of(const std::vector<double>& v) {
  Eigen::Matrix3d matrix;
  matrix << v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8];
  return matrix;
}

Rigid3 calib_transform(const std::string& path) {
  const std::vector<double> t = calib_numbers(path, "T", 3);
  return Rigid3(checked_rotation(path + ": R", rows_of(calib_numbers(path, "R", 9))),
                Eigen::Vector3d(t[0], t[1], t[2]));
}

/// "2011-09-26 13:02:25.951199337" -> seconds since 1970, the time zone taken for UTC.
double stamp_of_date(const std::string& where, std::string_view text) {
  const auto part = [&](size_t begin, size_t length) {
    return parse_uint(text.substr(std::min(begin, text.size()), length));
  };
  const auto year = part(0, 4), month = part(5, 2), day = part(8, 2), hour = part(11, 2), minute = part(14, 2);
  const std::optional<double> second = text.size() > 17 ? parse_double(text.substr(17)) : std::nullopt;
  if (!year || !month || !day || !hour || !minute || !second) {
    throw Error(fmt::format("{}: not a date and time: {}", where, in_quotes(text)));
  }
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) throw Error(fmt::format("{}: not a date: {}", where, in_quotes(text)));
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  return 86400.0 * static_cast<double>(days) + 3600.0 * static_cast<double>(*hour) +
         60.0 * static_cast<double>(*minute) + *second;
}

std::vector<double> read_dates(const std::string& path) {
  BlockReader reader(path);
  std::vector<double> stamps;
  for (std::string_view line; reader.take_line(&line);) {
    if (trim(line).empty()) continue;
    stamps.push_back(stamp_of_date(fmt::format("{}:{}", path, reader.line_number()), trim(line)));
  }
  return stamps;
}

/// Where GPS and IMU stood: x east, y north, z up, metres of the Mercator projection that is true at `scale`.
Rigid3 world_from_imu(const std::vector<double>& oxts, double scale) {
  constexpr double kEarthRadius = 6378137.0;
  const double latitude_deg = oxts[0];
  const double longitude_deg = oxts[1];
  const Eigen::Vector3d position(scale * kEarthRadius * longitude_deg * M_PI / 180.0,
                                 scale * kEarthRadius * std::log(std::tan((90.0 + latitude_deg) * M_PI / 360.0)),
                                 oxts[2]);
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(oxts[5], Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(oxts[4], Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(oxts[3], Eigen::Vector3d::UnitX());
  return {rotation, position};
}

/// map_from_lidar at the instants of GPS and IMU; the map is the LiDAR's frame at the first.
Trajectory read_trajectory(const fs::path& drive, const Rigid3& lidar_from_imu) {
  const std::vector<double> stamps = read_dates(required_file(drive.string(), "oxts/timestamps.txt"));
  const fs::path folder = drive / "oxts" / "data";
  const std::vector<std::string> files = files_with_extension(folder.string(), ".txt");
  if (files.empty() || files.size() != stamps.size()) {
    throw Error(fmt::format("{}: {} files for {} timestamps", folder.string(), files.size(), stamps.size()));
  }
  std::vector<StampedPose> poses;
  double scale = 0.0;
  Rigid3 imu_from_world;
  for (size_t i = 0; i < files.size(); ++i) {
    constexpr size_t kPoseNumbers = 6;  // latitude, longitude, altitude, roll, pitch, yaw
    const std::string file = (folder / files[i]).string();
    const std::vector<double> oxts = numbers_of(file, first_line(file), kPoseNumbers);
    if (i == 0) {
      scale = std::cos(oxts[0] * M_PI / 180.0);
      imu_from_world = inverse(world_from_imu(oxts, scale));
    }
    poses.push_back(
        {stamps[i], lidar_from_imu * imu_from_world * world_from_imu(oxts, scale) * inverse(lidar_from_imu)});
  }
  return order_by_stamp(poses).trajectory;
}

RigCamera rectified_camera(const std::string& date_folder) {
  const std::string path = required_file(date_folder, "calib_cam_to_cam.txt");
  const std::vector<double> p = calib_numbers(path, "P_rect_02", 12);
  const std::vector<double> size = calib_numbers(path, "S_rect_02", 2);
  if (p[0] == 0.0 || p[5] == 0.0) throw Error(fmt::format("{}: P_rect_02 has no focal length", path));
  const Rigid3 rectified_from_camera0(
      checked_rotation(path + ": R_rect_00", rows_of(calib_numbers(path, "R_rect_00", 9))), Eigen::Vector3d::Zero());
  // P = K [I | t].
  const double tz = p[11];
  const Rigid3 camera_from_rectified(Eigen::Quaterniond::Identity(),
                                     Eigen::Vector3d((p[3] - p[2] * tz) / p[0], (p[7] - p[6] * tz) / p[5], tz));
  RigCamera camera;
  camera.name = "image_02";
  camera.camera =
      Camera(CameraModel::kPinhole, static_cast<int>(size[0]), static_cast<int>(size[1]), {p[0], p[5], p[2], p[6]});
  camera.camera_from_lidar = camera_from_rectified * rectified_from_camera0 *
                             calib_transform(required_file(date_folder, "calib_velo_to_cam.txt"));
  return camera;
}

}  // namespace

ImportedProject import_kitti_raw(const std::string& folder) {
  // With a slash at its end whether it was given or not, so that the parent is the folder itself.
  const fs::path drive = fs::absolute(folder / fs::path("")).lexically_normal().parent_path();
  const std::string date_folder = drive.parent_path().string();
  ImportedProject project;
  project.rig = Rig{{rectified_camera(date_folder)}, RigFrame::kLidar};
  project.trajectory = read_trajectory(drive, calib_transform(required_file(date_folder, "calib_imu_to_velo.txt")));
  project.images = image_files((drive / "image_02" / "data").string());
  const std::vector<double> image_stamps = read_dates(required_file(drive.string(), "image_02/timestamps.txt"));
  if (image_stamps.size() != project.images.size()) {
    throw Error(fmt::format("{}: {} images for {} timestamps", (drive / "image_02").string(), project.images.size(),
                            image_stamps.size()));
  }
  for (size_t i = 0; i < image_stamps.size(); ++i) project.stamps_s[project.images[i].name] = image_stamps[i];

  const fs::path velodyne = drive / "velodyne_points";
  const std::vector<std::string> scans = files_with_extension((velodyne / "data").string(), ".bin");
  const std::vector<double> scan_stamps =
      scans.empty() ? std::vector<double>{}
                    : read_dates(required_file(drive.string(), "velodyne_points/timestamps.txt"));
  const TrajectorySpline spline(project.trajectory);
  size_t num_left_out = 0;
  for (size_t i = 0; i < scans.size(); ++i) {
    const std::optional<Rigid3> map_from_lidar =
        i < scan_stamps.size() ? spline.map_from_sensor(scan_stamps[i]) : std::nullopt;
    if (!map_from_lidar) {
      ++num_left_out;
      continue;
    }
    project.scans.push_back({(velodyne / "data" / scans[i]).string(), scans[i]});
    project.scan_poses.push_back({scan_stamps[i], *map_from_lidar});
  }
  if (num_left_out > 0) {
    project.notes.push_back(fmt::format("{}: {} of {} scans outside the trajectory, left out", velodyne.string(),
                                        num_left_out, scans.size()));
  }
  return project;
}

}  // namespace cpplus
