#include "cpplus/io/point_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

constexpr size_t kNumRoles = static_cast<size_t>(PointRole::kColorSpread) + 1;

/// The more usual spellings of a role first.
constexpr std::pair<std::string_view, PointRole> kSpellings[] = {
    {"x", PointRole::kX},
    {"y", PointRole::kY},
    {"z", PointRole::kZ},
    {"intensity", PointRole::kIntensity},
    {"intensities", PointRole::kIntensity},
    {"reflectance", PointRole::kIntensity},
    {"reflectivity", PointRole::kIntensity},
    {"timestamp", PointRole::kStamp},
    {"time", PointRole::kStamp},
    {"gpstime", PointRole::kStamp},
    {"gps_time", PointRole::kStamp},
    {"t", PointRole::kStamp},
    {"rgb", PointRole::kPackedRgb},
    {"rgba", PointRole::kPackedRgb},
    {"red", PointRole::kRed},
    {"r", PointRole::kRed},
    {"diffuse_red", PointRole::kRed},
    {"green", PointRole::kGreen},
    {"g", PointRole::kGreen},
    {"diffuse_green", PointRole::kGreen},
    {"blue", PointRole::kBlue},
    {"b", PointRole::kBlue},
    {"diffuse_blue", PointRole::kBlue},
    {"num_views", PointRole::kNumViews},
    {"best_image", PointRole::kBestImage},
    {"color_spread", PointRole::kColorSpread},
};

std::string bare_name(const std::string& field_name) {
  constexpr std::string_view kCloudComparePrefix = "scalar_";
  const std::string name = lower_case(field_name);
  return name.starts_with(kCloudComparePrefix) ? name.substr(kCloudComparePrefix.size()) : name;
}

template <typename T>
double load(const uint8_t* data, bool big_endian) {
  std::array<uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), data, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

}  // namespace

size_t scalar_size(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kInt64:
    case ScalarType::kUint64:
    case ScalarType::kFloat64:
      return 8;
  }
  return 0;
}

bool is_floating(ScalarType type) { return type == ScalarType::kFloat32 || type == ScalarType::kFloat64; }

double load_scalar(const uint8_t* data, ScalarType type, bool big_endian) {
  switch (type) {
    case ScalarType::kInt8:
      return load<int8_t>(data, big_endian);
    case ScalarType::kUint8:
      return load<uint8_t>(data, big_endian);
    case ScalarType::kInt16:
      return load<int16_t>(data, big_endian);
    case ScalarType::kUint16:
      return load<uint16_t>(data, big_endian);
    case ScalarType::kInt32:
      return load<int32_t>(data, big_endian);
    case ScalarType::kUint32:
      return load<uint32_t>(data, big_endian);
    case ScalarType::kInt64:
      return load<int64_t>(data, big_endian);
    case ScalarType::kUint64:
      return load<uint64_t>(data, big_endian);
    case ScalarType::kFloat32:
      return load<float>(data, big_endian);
    case ScalarType::kFloat64:
      return load<double>(data, big_endian);
  }
  return 0.0;
}

void assign_roles(std::vector<PointField>* fields) {
  for (PointField& field : *fields) field.role = PointRole::kNone;
  bool taken[kNumRoles] = {};
  for (const auto& [spelling, role] : kSpellings) {
    bool& role_taken = taken[static_cast<size_t>(role)];
    for (PointField& field : *fields) {
      if (role_taken || field.count != 1 || bare_name(field.name) != spelling) continue;
      if (role == PointRole::kPackedRgb && scalar_size(field.type) != 4) continue;
      field.role = role;
      role_taken = true;
    }
  }
  const auto is_taken = [&](PointRole role) { return taken[static_cast<size_t>(role)]; };
  const bool has_channels = is_taken(PointRole::kRed) && is_taken(PointRole::kGreen) && is_taken(PointRole::kBlue);
  if (has_channels && !is_taken(PointRole::kPackedRgb)) return;
  for (PointField& field : *fields) {
    if (field.role >= PointRole::kRed && field.role <= PointRole::kBlue) field.role = PointRole::kNone;
  }
}

double converted(const PointField& field, double value) {
  switch (field.role) {
    case PointRole::kStamp:
      return is_floating(field.type) ? value : value * 1e-9;
    case PointRole::kRed:
    case PointRole::kGreen:
    case PointRole::kBlue:
      if (is_floating(field.type)) return std::round(value * 255.0);
      return scalar_size(field.type) > 1 ? std::floor(value / 256.0) : value;
    default:
      return value;
  }
}

}  // namespace cpplus
