#include "cpplus/pipeline/drawn_points.h"

#include <algorithm>
#include <vector>

#include "cpplus/report/render_cloud.h"

namespace cpplus {
namespace {

struct DrawnPoint {
  uint32_t point = 0;  // in map order
  ColoredPoint colored;
};

/// Of one root.
void add_drawn(const ColoredCloud& cloud, uint32_t root, const DepthBuffer& surface, const Rigid3& camera_from_map,
               std::vector<DrawnPoint>* drawn) {
  const VoxelMap& map = cloud.points.map;
  const uint32_t begin = map.points_begin(0, root);
  std::vector<ColoredPoint> colored;  // found where a point is drawn
  for (uint32_t i = begin; i < map.points_end(0, root); ++i) {
    if (!is_drawn(camera_from_map * map.point(i), surface)) continue;
    if (colored.empty()) colored = cloud.colors.of_root(root);
    drawn->push_back({i, colored[i - begin]});
  }
}

}  // namespace

PointCloud drawn_points(const ColoredCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map) {
  const VoxelMap& map = cloud.points.map;
  std::vector<DrawnPoint> drawn;
  for (const uint32_t root : cloud.colors.roots) add_drawn(cloud, root, surface, camera_from_map, &drawn);
  std::sort(drawn.begin(), drawn.end(), [&](const DrawnPoint& a, const DrawnPoint& b) {
    return map.input_index(a.point) < map.input_index(b.point);
  });
  PointCloud points;
  points.origin = map.origin();
  for (const auto& [i, colored] : drawn) {
    points.positions.push_back(map.positions()[i]);
    points.colors.push_back(colored.num_views > 0 ? colored.color
                                                  : cloud.grays.gray_of_point(cloud.points.intensities, i));
    points.num_views.push_back(colored.num_views);
  }
  return points;
}

}  // namespace cpplus
