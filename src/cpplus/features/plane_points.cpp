#include "cpplus/features/plane_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cpplus {

PlanePoints plane_points(const VoxelMap& map, const PlaneSegmentation& planes, size_t plane) {
  PlanePoints result;
  const MapPlane& p = planes.planes[plane];
  result.origin = p.centroid;
  result.normal = p.normal;
  result.axis_u = p.normal.unitOrthogonal();
  result.axis_v = p.normal.cross(result.axis_u);
  for (const uint32_t leaf : planes.leaves[plane]) {
    for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
      if (planes.plane_of_point[i] != static_cast<int32_t>(plane)) continue;
      const Eigen::Vector3d d = map.point(i) - p.centroid;
      result.positions.emplace_back(result.axis_u.dot(d), result.axis_v.dot(d));
      result.indices.push_back(i);
    }
  }
  return result;
}

std::vector<uint32_t> thin_points(const PlanePoints& points, double cell_m) {
  struct Item {
    int64_t cell;
    uint32_t index;
  };
  std::vector<Item> items;
  items.reserve(points.positions.size());
  for (uint32_t i = 0; i < points.positions.size(); ++i) {
    const int64_t x = static_cast<int64_t>(std::floor(points.positions[i].x() / cell_m));
    const int64_t y = static_cast<int64_t>(std::floor(points.positions[i].y() / cell_m));
    items.push_back({x * (int64_t{1} << 32) + y, i});
  }
  std::sort(items.begin(), items.end(),
            [](const Item& a, const Item& b) { return a.cell != b.cell ? a.cell < b.cell : a.index < b.index; });
  std::vector<uint32_t> kept;
  for (size_t begin = 0; begin < items.size();) {
    size_t end = begin;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    while (end < items.size() && items[end].cell == items[begin].cell) mean += points.positions[items[end++].index];
    mean /= static_cast<double>(end - begin);
    uint32_t best = items[begin].index;
    for (size_t k = begin; k < end; ++k) {
      if ((points.positions[items[k].index] - mean).squaredNorm() < (points.positions[best] - mean).squaredNorm()) {
        best = items[k].index;
      }
    }
    kept.push_back(best);
    begin = end;
  }
  return kept;
}

}  // namespace cpplus
