#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/cloud_builder.h"
#include "cpplus/io/point_fields.h"

namespace cpplus {

/// The points of a file from front to back, some at a time: what a reader of a format provides. Memory does not grow
/// with the file.
class CloudSource {
 public:
  virtual ~CloudSource() = default;

  /// As the header says, checked against the size of the file.
  virtual size_t num_points() const = 0;
  virtual const std::vector<PointField>& fields() const = 0;
  virtual std::optional<LasFrame> las_frame() const { return std::nullopt; }

  /// Sets points [0, count) of the builder to the next `count` points of the file, which it must still have. Throws
  /// Error for a file that does not hold them, and at its end for one that holds more than its header says.
  virtual void read(size_t count, CloudBuilder* builder) = 0;
};

/// Opens a point cloud in the format of its extension (.pcd, .ply, .las; any case) and reads its header.
std::unique_ptr<CloudSource> open_point_cloud(const std::string& path);

/// Reads a file block by block.
class CloudBlocks {
 public:
  explicit CloudBlocks(const std::string& path);

  const CloudSource& source() const { return *source_; }
  /// The next block, at most `max_points` of the file's points without those that are not finite; the vectors of
  /// `block` are used again. False at the end of the file. The block's origin is that of the whole file as CloudBuilder
  /// chooses it, once there was a finite point. Throws Error at the end of a file without any finite point.
  bool next(size_t max_points, PointCloud* block);
  size_t num_dropped() const { return num_dropped_; }

 private:
  std::string path_;
  std::unique_ptr<CloudSource> source_;
  CloudBuilder builder_;
  size_t num_read_ = 0;
  size_t num_dropped_ = 0;
};

}  // namespace cpplus
