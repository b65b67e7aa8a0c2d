#include "cpplus/cloud/point_map.h"

#include "cpplus/cloud/owned_map_arrays.h"
#include "cpplus/core/error.h"

namespace cpplus {
namespace {

template <typename T>
std::vector<T> in_input_order(const VoxelMap& map, std::span<const T> values) {
  std::vector<T> ordered(values.size());
  for (size_t i = 0; i < values.size(); ++i) ordered[map.input_index(i)] = values[i];
  return ordered;
}

}  // namespace

PointMap make_point_map(const PointCloud& cloud, const VoxelMapOptions& options) {
  PointMap points;
  points.map = VoxelMap(cloud, options);
  const auto attributes = std::make_shared<const OwnedAttributes>(
      OwnedAttributes{in_map_order(points.map, cloud.intensities), in_map_order(points.map, cloud.colors),
                      in_map_order(points.map, cloud.stamps_s), in_map_order(points.map, cloud.num_views),
                      in_map_order(points.map, cloud.best_images), in_map_order(points.map, cloud.color_spreads)});
  points.las_frame = cloud.las_frame;
  attributes->view(attributes, &points);
  return points;
}

PointCloud cloud_in_input_order(const PointMap& points) {
  const VoxelMap& map = points.map;
  std::vector<bool> found(map.num_points(), false);
  for (size_t i = 0; i < map.num_points(); ++i) {
    const uint32_t index = map.input_index(i);
    if (index >= found.size() || found[index]) throw Error("the indices of the map's points are damaged");
    found[index] = true;
  }
  PointCloud cloud;
  cloud.origin = map.origin();
  cloud.positions = in_input_order(map, map.positions());
  cloud.intensities = in_input_order(map, points.intensities);
  cloud.colors = in_input_order(map, points.colors);
  cloud.stamps_s = in_input_order(map, points.stamps_s);
  cloud.num_views = in_input_order(map, points.num_views);
  cloud.best_images = in_input_order(map, points.best_images);
  cloud.color_spreads = in_input_order(map, points.color_spreads);
  cloud.las_frame = points.las_frame;
  return cloud;
}

}  // namespace cpplus
