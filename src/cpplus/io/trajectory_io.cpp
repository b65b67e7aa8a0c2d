#include "cpplus/io/trajectory_io.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

constexpr size_t kNumValues = 8;

std::array<double, kNumValues> parse_values(const std::string& where, std::string_view line) {
  if (line.find(',') != std::string_view::npos) {
    throw Error(fmt::format("{}: TUM lines are separated by blanks, this one has commas: {}", where, in_quotes(line)));
  }
  std::vector<std::string_view> words;
  split_words(line, &words);
  if (words.size() != kNumValues) {
    throw Error(fmt::format("{}: {} values instead of the 8 of `stamp tx ty tz qx qy qz qw`", where, words.size()));
  }
  std::array<double, kNumValues> values;
  for (size_t i = 0; i < kNumValues; ++i) {
    const std::optional<double> value = parse_double(words[i]);
    if (!value || !std::isfinite(*value)) {
      throw Error(fmt::format("{}: not a finite number: {}", where, in_quotes(words[i])));
    }
    values[i] = *value;
  }
  return values;
}

}  // namespace

Trajectory read_tum(const std::string& path) {
  BlockReader reader(path);
  Trajectory trajectory;
  std::string_view line;
  while (reader.take_line(&line)) {
    line = trim(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::string where = fmt::format("{}:{}", path, reader.line_number());
    const std::array<double, kNumValues> values = parse_values(where, line);
    const Eigen::Quaterniond rotation(values[7], values[4], values[5], values[6]);
    constexpr double kMaxNormError = 0.01;
    if (std::abs(rotation.norm() - 1.0) > kMaxNormError) {
      throw Error(fmt::format("{}: the quaternion has length {:.6g}, not 1", where, rotation.norm()));
    }
    if (!trajectory.empty() && values[0] <= trajectory.back().stamp_s) {
      throw Error(fmt::format("{}: stamp {} does not come after {}", where, values[0], trajectory.back().stamp_s));
    }
    StampedPose pose;
    pose.stamp_s = values[0];
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    pose.map_from_sensor.rotation =
        std::abs(rotation.squaredNorm() - 1.0) <= kRounding ? rotation : rotation.normalized();
    pose.map_from_sensor.translation = {values[1], values[2], values[3]};
    trajectory.push_back(pose);
  }
  if (trajectory.empty()) throw Error(fmt::format("{}: holds no poses", path));
  return trajectory;
}

void write_tum(const std::string& path, const Trajectory& trajectory) {
  AtomicFile file(path);
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& t = pose.map_from_sensor.translation;
    const Eigen::Quaterniond& q = pose.map_from_sensor.rotation;
    file.stream() << fmt::format("{} {} {} {} {} {} {} {}\n", pose.stamp_s, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                                 q.w());
  }
  file.commit();
}

void write_kitti(const std::string& path, const Trajectory& trajectory) {
  AtomicFile file(path);
  for (const StampedPose& pose : trajectory) {
    const Eigen::Matrix3d rotation = pose.map_from_sensor.rotation.toRotationMatrix();
    for (int row = 0; row < 3; ++row) {
      file.stream() << fmt::format("{}{} {} {} {}", row == 0 ? "" : " ", rotation(row, 0), rotation(row, 1),
                                   rotation(row, 2), pose.map_from_sensor.translation[row]);
    }
    file.stream() << "\n";
  }
  file.commit();
}

void write_times(const std::string& path, const Trajectory& trajectory) {
  AtomicFile file(path);
  for (const StampedPose& pose : trajectory) file.stream() << fmt::format("{}\n", pose.stamp_s);
  file.commit();
}

}  // namespace cpplus
