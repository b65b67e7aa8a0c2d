#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/atomic_file.h"

namespace cpplus {

/// The records of a binary PCD file: the values of its header's lines, each with a space before it.
struct PcdLayout {
  std::string fields, sizes, types, counts;
  size_t record_size = 0;  // bytes
};

/// Writes a binary PCD file whose number of points shows only in the end, as write_pcd() does but for the padding of
/// its header.
class PcdWriter {
 public:
  explicit PcdWriter(const std::string& path);

  /// All blocks have the same origin and attributes. Throws Error where they cannot be written.
  void add(const PointCloud& block);
  size_t num_points() const { return num_points_; }
  /// The file is there from now on.
  void commit();

 private:
  AtomicFile file_;
  std::optional<PcdLayout> layout_;
  size_t num_points_ = 0;
};

}  // namespace cpplus
