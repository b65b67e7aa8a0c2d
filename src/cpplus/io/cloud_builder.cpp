#include "cpplus/io/cloud_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

constexpr double kLocalCoordinate = 1000.0;  // metres

template <typename T>
T clamped(double value) {
  if (std::isnan(value)) return 0;
  return static_cast<T>(std::clamp(value, 0.0, static_cast<double>(std::numeric_limits<T>::max())));
}

/// Half the distance from |value| to the next float32.
double float_rounding(float value) {
  const float magnitude = std::abs(value);
  return 0.5 * (std::nextafter(magnitude, std::numeric_limits<float>::infinity()) - magnitude);
}

template <typename T>
void keep(std::vector<T>* values, size_t to, size_t from) {
  if (!values->empty()) (*values)[to] = (*values)[from];
}

}  // namespace

CloudBuilder::CloudBuilder(const std::string& path, size_t num_points, const std::vector<PointField>& fields)
    : path_(path) {
  for (const PointField& field : fields) roles_.push_back(field.role);
  for (const PointRole role : {PointRole::kX, PointRole::kY, PointRole::kZ}) {
    if (std::find(roles_.begin(), roles_.end(), role) != roles_.end()) continue;
    std::string names;
    for (const PointField& field : fields) names += " " + field.name;
    throw Error(fmt::format("{}: has no x, y and z: its fields are{}", path, names));
  }
  rounds_ = std::any_of(fields.begin(), fields.end(), [](const PointField& field) {
    return field.role >= PointRole::kX && field.role <= PointRole::kZ && field.type != ScalarType::kFloat32;
  });
  resize(num_points);
}

void CloudBuilder::resize(size_t num_points) {
  const auto has = [&](PointRole role) { return std::find(roles_.begin(), roles_.end(), role) != roles_.end(); };
  cloud_.positions.resize(num_points);
  cloud_.intensities.resize(has(PointRole::kIntensity) ? num_points : 0);
  cloud_.colors.resize(has(PointRole::kPackedRgb) || has(PointRole::kRed) ? num_points : 0);
  cloud_.stamps_s.resize(has(PointRole::kStamp) ? num_points : 0);
  cloud_.num_views.resize(has(PointRole::kNumViews) ? num_points : 0);
  cloud_.best_images.resize(has(PointRole::kBestImage) ? num_points : 0);
  cloud_.color_spreads.resize(has(PointRole::kColorSpread) ? num_points : 0);
}

void CloudBuilder::set_coordinate(size_t point, int axis, double value) {
  if (!origin_known_[axis] && std::isfinite(value)) {
    origin_known_[axis] = true;
    cloud_.origin[axis] = std::abs(value) < kLocalCoordinate ? 0.0 : std::round(value);
  }
  cloud_.positions[point][axis] = static_cast<float>(value - cloud_.origin[axis]);
}

void CloudBuilder::set(size_t point, PointRole role, double value) {
  switch (role) {
    case PointRole::kNone:
      return;
    case PointRole::kX:
      return set_coordinate(point, 0, value);
    case PointRole::kY:
      return set_coordinate(point, 1, value);
    case PointRole::kZ:
      return set_coordinate(point, 2, value);
    case PointRole::kIntensity:
      cloud_.intensities[point] = static_cast<float>(value);
      return;
    case PointRole::kStamp:
      cloud_.stamps_s[point] = value;
      return;
    case PointRole::kRed:
      cloud_.colors[point][0] = clamped<uint8_t>(value);
      return;
    case PointRole::kGreen:
      cloud_.colors[point][1] = clamped<uint8_t>(value);
      return;
    case PointRole::kBlue:
      cloud_.colors[point][2] = clamped<uint8_t>(value);
      return;
    case PointRole::kPackedRgb:
      return set_packed_rgb(point, clamped<uint32_t>(value));
    case PointRole::kNumViews:
      cloud_.num_views[point] = clamped<uint16_t>(value);
      return;
    case PointRole::kBestImage:
      cloud_.best_images[point] = clamped<uint32_t>(value);
      return;
    case PointRole::kColorSpread:
      cloud_.color_spreads[point] = clamped<uint8_t>(value);
      return;
  }
}

void CloudBuilder::set_packed_rgb(size_t point, uint32_t rgb) {
  cloud_.colors[point] = {static_cast<uint8_t>(rgb >> 16), static_cast<uint8_t>(rgb >> 8), static_cast<uint8_t>(rgb)};
}

void CloudBuilder::set_from_bytes(size_t point, const PointField& field, const uint8_t* data, bool big_endian) {
  // A packed colour is four bytes, also where the file calls them a float.
  const ScalarType type =
      field.role == PointRole::kPackedRgb && scalar_size(field.type) == 4 ? ScalarType::kUint32 : field.type;
  set(point, field.role, converted(field, load_scalar(data, type, big_endian)));
}

void CloudBuilder::set_column(size_t first, size_t size, const PointField& field, const uint8_t* data, size_t stride) {
  const int axis = static_cast<int>(field.role) - static_cast<int>(PointRole::kX);
  const bool is_coordinate = axis >= 0 && axis < 3;
  size_t i = 0;
  // What nearly all scans hold, without a decision a value. Coordinates only once their origin is known.
  if (field.type == ScalarType::kFloat32 && (is_coordinate || field.role == PointRole::kIntensity)) {
    for (; is_coordinate && i < size && !origin_known_[axis]; ++i) {
      set_from_bytes(first + i, field, data + i * stride, false);
    }
    for (; i < size; ++i) {
      float value;
      std::memcpy(&value, data + i * stride, sizeof(value));
      if (is_coordinate) {
        cloud_.positions[first + i][axis] = static_cast<float>(value - cloud_.origin[axis]);
      } else {
        cloud_.intensities[first + i] = value;
      }
    }
  }
  for (; i < size; ++i) set_from_bytes(first + i, field, data + i * stride, false);
}

std::vector<size_t> CloudBuilder::drop_non_finite() {
  const size_t size = cloud_.size();
  size_t kept = 0;
  std::vector<size_t> dropped;
  for (size_t i = 0; i < size; ++i) {
    if (!cloud_.positions[i].allFinite()) {
      dropped.push_back(i);
      continue;
    }
    if (kept != i) {
      keep(&cloud_.positions, kept, i);
      keep(&cloud_.intensities, kept, i);
      keep(&cloud_.colors, kept, i);
      keep(&cloud_.stamps_s, kept, i);
      keep(&cloud_.num_views, kept, i);
      keep(&cloud_.best_images, kept, i);
      keep(&cloud_.color_spreads, kept, i);
    }
    ++kept;
  }
  resize(kept);
  return dropped;
}

void CloudBuilder::swap(PointCloud* cloud) {
  std::swap(cloud_, *cloud);
  cloud_.origin = cloud->origin;
}

PointCloud CloudBuilder::finish(ReadCounts* counts) {
  const size_t in_file = cloud_.size();
  std::vector<size_t> dropped = drop_non_finite();
  if (cloud_.empty()) throw_no_finite_points(path_, in_file);
  if (counts != nullptr) {
    Eigen::Array3f farthest = Eigen::Array3f::Zero();
    for (const Eigen::Vector3f& position : cloud_.positions) farthest = farthest.max(position.array().abs());
    *counts = {in_file, dropped.size(),
               rounds_ || !cloud_.origin.isZero(0.0) ? float_rounding(farthest.maxCoeff()) : 0.0, std::move(dropped)};
  }
  return std::move(cloud_);
}

void throw_no_finite_points(const std::string& path, size_t num_points) {
  throw Error(num_points == 0 ? fmt::format("{}: holds no points", path)
                              : fmt::format("{}: none of its {} points is finite", path, num_points));
}

}  // namespace cpplus
