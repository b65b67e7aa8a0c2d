#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// A voxel map and the attributes of its points, all in map order: element i belongs to map.positions()[i]. Each
/// attribute is empty (the cloud does not have it) or as long as the positions; units as in PointCloud. Like the map,
/// the attributes lie in memory or in a mapped file alike; `owner` keeps them alive, and copies share them.
struct PointMap {
  VoxelMap map;
  std::span<const float> intensities;
  std::span<const Rgb> colors;
  std::span<const double> stamps_s;
  std::span<const uint16_t> num_views;
  std::span<const uint32_t> best_images;
  std::span<const uint8_t> color_spreads;
  std::optional<LasFrame> las_frame;
  size_t num_dropped_non_finite = 0;  // points of the files that were left out when they were read
  std::shared_ptr<const void> owner;
};

/// Builds the map of a cloud; the attributes are copied, the cloud may go. Throws what VoxelMap's constructor does.
PointMap make_point_map(const PointCloud& cloud, const VoxelMapOptions& options);

/// The points as they were before they were sorted, with their attributes. Throws Error where the map's indices are
/// not those of its own points, as in a damaged file, or in a map that left out points.
PointCloud cloud_in_input_order(const PointMap& points);

/// Values of the input's points (may be empty), in map order.
template <typename T>
std::vector<T> in_map_order(const VoxelMap& map, const std::vector<T>& values) {
  std::vector<T> ordered;
  if (values.empty()) return ordered;
  ordered.reserve(map.num_points());
  for (size_t i = 0; i < map.num_points(); ++i) ordered.push_back(values[map.input_index(i)]);
  return ordered;
}

}  // namespace cpplus
