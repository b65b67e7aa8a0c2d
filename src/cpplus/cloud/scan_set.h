#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

/// Scans in the map frame, one after the other in one cloud.
struct ScanSet {
  PointCloud points;
  std::vector<size_t> first_point = {0};        // scans + 1, ascending; the last is points.size()
  std::vector<Eigen::Vector3d> sensors_in_map;  // where the rays of each scan start, metres

  size_t num_scans() const { return sensors_in_map.size(); }
};

}  // namespace cpplus
