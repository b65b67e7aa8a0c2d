#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/point_fields.h"

namespace cpplus {

/// What became of the points of a file.
struct ReadCounts {
  size_t in_file = 0;
  size_t dropped_non_finite = 0;  // NaN or infinite coordinates
  /// Largest coordinate error from keeping positions as float32 offsets, metres: half the spacing of float32 at the
  /// point farthest from the origin along an axis (0.03 mm at 1 km, 0.5 mm at 10 km). 0 for a local float32 file.
  double max_rounding_m = 0.0;
  std::vector<size_t> dropped_points;  // which ones, by their place in the file, ascending
};

/// Collects the values of a file's fields into a PointCloud of a size known beforehand, in any order (file formats come
/// by records or by columns).
///
/// The origin: a coordinate whose first finite value lies within 1 km of zero gets origin 0, so local maps keep their
/// numbers as they are; beyond, that value rounded to a metre, so georeferenced maps keep their millimetres.
class CloudBuilder {
 public:
  /// Makes room for num_points points with the attributes whose roles occur in `fields`. The caller has checked
  /// num_points against the size of the file. Throws Error when x, y or z is missing.
  CloudBuilder(const std::string& path, size_t num_points, const std::vector<PointField>& fields);

  size_t num_points() const { return cloud_.positions.size(); }
  void set(size_t point, PointRole role, double value);
  void set_packed_rgb(size_t point, uint32_t rgb);
  /// Decodes one binary field: load, convert, set.
  void set_from_bytes(size_t point, const PointField& field, const uint8_t* data, bool big_endian);

  /// The same for one little-endian field of `size` points from `first` on, whose records are `stride` bytes apart.
  void set_column(size_t first, size_t size, const PointField& field, const uint8_t* data, size_t stride);

  /// For another block of the same file: the origin stays once it is chosen.
  void resize(size_t num_points);
  /// Closes the gaps that they leave; returns their places, ascending.
  std::vector<size_t> drop_non_finite();
  /// Exchanges the points for those of another cloud; the origin stays, and the other gets it as well.
  void swap(PointCloud* cloud);

  /// Drops non-finite points and hands the cloud over. Throws Error when no point is left.
  PointCloud finish(ReadCounts* counts);

 private:
  void set_coordinate(size_t point, int axis, double value);

  std::string path_;
  std::vector<PointRole> roles_;
  PointCloud cloud_;
  bool origin_known_[3] = {false, false, false};
  bool rounds_ = false;
};

/// Throws the Error of a file whose points are all not finite, or that has none.
[[noreturn]] void throw_no_finite_points(const std::string& path, size_t num_points);

}  // namespace cpplus
