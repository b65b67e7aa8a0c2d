#include "cpplus/io/pose_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/image_stamps.h"
#include "cpplus/io/rotation_check.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

using Words = std::vector<std::string_view>;

constexpr size_t kTumValues = 8;
constexpr size_t kKittiValues = 12;

double finite_number(const std::string& where, std::string_view word) {
  const std::optional<double> value = parse_double(word);
  if (!value || !std::isfinite(*value)) {
    throw Error(fmt::format("{}: not a finite number: {}", where, in_quotes(word)));
  }
  return *value;
}

std::vector<double> finite_numbers(const std::string& where, const Words& words) {
  std::vector<double> numbers;
  for (const std::string_view word : words) numbers.push_back(finite_number(where, word));
  return numbers;
}

StampedPose tum_pose(const std::string& where, const Words& words) {
  const std::vector<double> v = finite_numbers(where, words);
  return {v[0], Rigid3(checked_rotation(where, Eigen::Quaterniond(v[7], v[4], v[5], v[6])),
                       Eigen::Vector3d(v[1], v[2], v[3]))};
}

Rigid3 kitti_pose(const std::string& where, const Words& words) {
  const std::vector<double> v = finite_numbers(where, words);
  Eigen::Matrix3d rotation;
  rotation << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  return Rigid3(checked_rotation(where, rotation), Eigen::Vector3d(v[3], v[7], v[11]));
}

enum Column { kStamp, kX, kY, kZ, kQx, kQy, kQz, kQw, kNumColumns };
constexpr std::array<const char*, kNumColumns> kColumnNames = {"stamp", "x", "y", "z", "qx", "qy", "qz", "qw"};

/// "#p_RS_R_x [m]" -> {"p", "rs", "r", "x"}; a unit in brackets goes to `unit`.
std::vector<std::string> name_parts(std::string_view name, std::string* unit) {
  std::vector<std::string> parts(1);
  std::string lower = lower_case(name);
  const size_t bracket = lower.find('[');
  if (bracket != std::string::npos) {
    *unit = lower.substr(bracket + 1, lower.find(']') - bracket - 1);
    lower.resize(bracket);
  }
  for (const char c : lower) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      parts.back() += c;
    } else if (!parts.back().empty()) {
      parts.emplace_back();
    }
  }
  if (parts.back().empty() && parts.size() > 1) parts.pop_back();
  return parts;
}

std::optional<Column> axis_of(const std::string& letter, bool is_quaternion) {
  if (letter == "x") return is_quaternion ? kQx : kX;
  if (letter == "y") return is_quaternion ? kQy : kY;
  if (letter == "z") return is_quaternion ? kQz : kZ;
  if (letter == "w" && is_quaternion) return kQw;
  return {};
}

std::optional<Column> column_of(const std::vector<std::string>& parts) {
  static const std::set<std::string> stamps = {"timestamp", "time", "stamp", "t", "sec", "secs", "seconds"};
  static const std::set<std::string> quaternions = {"q", "quat", "quaternion", "orientation", "rot", "rotation"};
  static const std::set<std::string> positions = {"p", "t", "pos", "position", "translation"};
  const std::string& last = parts.back();
  if (stamps.count(last) > 0 || (parts.size() > 1 && (last == "s" || last == "ms" || last == "us" || last == "ns") &&
                                 stamps.count(parts[parts.size() - 2]) > 0)) {
    return kStamp;
  }
  if (last.size() == 2 && (last[0] == 't' || last[0] == 'p' || last[0] == 'q'))
    return axis_of(last.substr(1), last[0] == 'q');
  bool is_quaternion = false;
  bool is_position = parts.size() == 1;
  for (size_t i = 0; i + 1 < parts.size(); ++i) {
    is_quaternion = is_quaternion || quaternions.count(parts[i]) > 0;
    is_position = is_position || positions.count(parts[i]) > 0;
  }
  return is_quaternion || is_position ? axis_of(last, is_quaternion) : std::nullopt;
}

/// Where the columns of a csv file are.
struct CsvLayout {
  std::array<size_t, kNumColumns> index{};
  size_t num_columns = 0;
  StampUnit stamp_unit = StampUnit::kAuto;
};

CsvLayout csv_layout(const std::string& where, const Words& header) {
  CsvLayout layout;
  layout.num_columns = header.size();
  std::array<bool, kNumColumns> found{};
  for (size_t i = 0; i < header.size(); ++i) {
    std::string unit;
    const std::vector<std::string> parts = name_parts(header[i], &unit);
    const std::optional<Column> column = column_of(parts);
    if (!column || found[*column]) continue;  // of columns with the same meaning the first counts
    found[*column] = true;
    layout.index[*column] = i;
    if (*column == kStamp) {
      layout.stamp_unit = stamp_unit_from_name(unit.empty() ? parts.back() : unit).value_or(StampUnit::kAuto);
    }
  }
  for (size_t column = 0; column < kNumColumns; ++column) {
    if (!found[column]) throw Error(fmt::format("{}: its header names no column for {}", where, kColumnNames[column]));
  }
  return layout;
}

StampedPose csv_pose(const std::string& where, const Words& words, const CsvLayout& layout) {
  if (words.size() != layout.num_columns) {
    throw Error(fmt::format("{}: {} values instead of the header's {}", where, words.size(), layout.num_columns));
  }
  const auto number = [&](Column column) { return finite_number(where, words[layout.index[column]]); };
  const std::string_view stamp_word = words[layout.index[kStamp]];
  const std::optional<double> stamp = parse_stamp(stamp_word, layout.stamp_unit);
  if (!stamp) throw Error(fmt::format("{}: not a stamp: {}", where, in_quotes(stamp_word)));
  return {*stamp,
          Rigid3(checked_rotation(where, Eigen::Quaterniond(number(kQw), number(kQx), number(kQy), number(kQz))),
                 Eigen::Vector3d(number(kX), number(kY), number(kZ)))};
}

std::vector<StampedPose> read_csv(BlockReader* reader, std::string_view header) {
  const auto where = [&] { return fmt::format("{}:{}", reader->path(), reader->line_number()); };
  Words words;
  split_at_commas(header, &words);
  const CsvLayout layout = csv_layout(where(), words);
  std::vector<StampedPose> poses;
  for (std::string_view line; reader->take_line(&line);) {
    line = trim(line);
    if (line.empty() || line.front() == '#') continue;
    split_at_commas(line, &words);
    poses.push_back(csv_pose(where(), words, layout));
  }
  return poses;
}

void add_times(const std::string& path, const std::string& times, std::vector<StampedPose>* poses) {
  if (times.empty()) {
    throw Error(fmt::format("{}: KITTI poses have no stamps; a file of one stamp a line must be given as well", path));
  }
  const std::vector<double> stamps = read_times(times);
  if (stamps.size() != poses->size()) {
    throw Error(fmt::format("{}: {} stamps for the {} poses of {}", times, stamps.size(), poses->size(), path));
  }
  for (size_t i = 0; i < stamps.size(); ++i) (*poses)[i].stamp_s = stamps[i];
}

}  // namespace

std::vector<double> read_times(const std::string& path) {
  BlockReader reader(path);
  std::vector<double> times;
  for (std::string_view line; reader.take_line(&line);) {
    line = trim(line);
    if (line.empty() || line.front() == '#') continue;
    times.push_back(finite_number(fmt::format("{}:{}", path, reader.line_number()), line));
  }
  return times;
}

std::vector<StampedPose> read_pose_file(const std::string& path, const std::string& times) {
  BlockReader reader(path);
  std::vector<StampedPose> poses;
  Words words;
  bool is_kitti = false;
  for (std::string_view line; reader.take_line(&line);) {
    const bool is_csv = poses.empty() && line.find(',') != std::string_view::npos;
    if (is_csv) {
      poses = read_csv(&reader, line);
      break;
    }
    line = trim(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::string where = fmt::format("{}:{}", path, reader.line_number());
    split_words(line, &words);
    if (poses.empty()) is_kitti = words.size() == kKittiValues;
    if (words.size() != (is_kitti ? kKittiValues : kTumValues)) {
      throw Error(fmt::format("{}: {} values, neither the 8 of `stamp tx ty tz qx qy qz qw` nor the 12 of a matrix",
                              where, words.size()));
    }
    poses.push_back(is_kitti ? StampedPose{0.0, kitti_pose(where, words)} : tum_pose(where, words));
  }
  if (poses.empty()) throw Error(fmt::format("{}: holds no poses", path));
  if (is_kitti) add_times(path, times, &poses);
  return poses;
}

}  // namespace cpplus
