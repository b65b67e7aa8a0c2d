#pragma once

#include <cstddef>
#include <functional>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

/// A cloud that need not be in memory as a whole: it is passed over in blocks of consecutive points, as often as
/// wanted.
struct CloudStream {
  size_t num_points = 0;
  /// Visits all points from the first to the last, in at least one block. The blocks have the same origin, LAS frame
  /// and attributes.
  std::function<void(const std::function<void(const PointCloud& block)>& visit)> for_each_block;
};

/// One block; the cloud must outlive it.
inline CloudStream stream_of(const PointCloud& cloud) {
  return {cloud.size(), [&cloud](const auto& visit) { visit(cloud); }};
}

}  // namespace cpplus
