#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/cloud_stream.h"
#include "cpplus/io/point_attributes.h"
#include "cpplus/io/point_buckets.h"

namespace cpplus {

/// Brings the points of a map back into the order of the input, on the disk: memory does not grow with the map but for
/// some bytes a block of points.
class OrderedPoints {
 public:
  /// `map`: file that errors name; `target`: file that this is for, see ScratchFile. `attributes`: those of all blocks.
  OrderedPoints(const std::string& map, const std::string& target, size_t num_points,
                const PointAttributes& attributes);

  /// `indices`: places of the points in the input. Throws Error where one is too large or too many lie close together.
  void add(const PointCloud& points, std::span<const uint32_t> indices);

  /// After all points, which are then visited in their order, about the origin. This must outlive the stream. Throws
  /// Error, as do the visits, where places are missing or taken twice.
  CloudStream finish(const Eigen::Vector3d& origin, const std::optional<LasFrame>& las_frame);

 private:
  PointCloud in_order(size_t block_number, const PointBucket& points) const;
  [[noreturn]] void fail() const;

  std::string map_;
  size_t num_points_;
  size_t num_blocks_;
  PointAttributes attributes_;
  PointBuckets buckets_;
};

}  // namespace cpplus
