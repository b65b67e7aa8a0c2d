#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cpplus {

static_assert(std::endian::native == std::endian::little, "The binary readers and writers assume a little-endian host");

/// Type of one number in a binary record.
enum class ScalarType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat32, kFloat64 };

size_t scalar_size(ScalarType type);
bool is_floating(ScalarType type);

/// The number at `data` (no alignment needed), as double; big_endian swaps its bytes first.
double load_scalar(const uint8_t* data, ScalarType type, bool big_endian);

/// What a field of a file means to a PointCloud.
enum class PointRole {
  kNone,
  kX,
  kY,
  kZ,
  kIntensity,
  kStamp,
  kRed,
  kGreen,
  kBlue,
  kPackedRgb,
  kNumViews,
  kBestImage,
  kColorSpread
};

/// A field of the records of a file.
struct PointField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  size_t count = 1;   // numbers in the field; only fields of one number get a role
  size_t offset = 0;  // bytes from the start of the record
  PointRole role = PointRole::kNone;
};

/// Gives each field the role its name stands for, in the spellings of PCL, Open3D, CloudCompare and the usual LiDAR
/// drivers; case and CloudCompare's "scalar_" do not matter. Of several fields for one role ("intensity" and
/// "reflectivity") the more usual name gets it; a packed colour goes before single channels, which
/// count only as all three.
void assign_roles(std::vector<PointField>* fields);

/// The value as PointCloud keeps it. Times of an integer type are nanoseconds (the drivers' habit) and become seconds;
/// colours of a floating type run to 1, of 16 bits to 65535, and become 0..255.
double converted(const PointField& field, double value);

}  // namespace cpplus
