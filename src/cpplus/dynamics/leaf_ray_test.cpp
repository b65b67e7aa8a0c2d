#include "cpplus/dynamics/leaf_ray.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using testing::ElementsAre;
using testing::IsEmpty;

/// Leaves of 1 m, roots of 4 m.
VoxelMap metre_map(const std::vector<Vector3d>& points) {
  PointCloud cloud;
  for (const Vector3d& point : points) cloud.positions.push_back(point.cast<float>());
  VoxelMapOptions options;
  options.root_size_m = 4.0;
  options.leaf_size_m = 1.0;
  return VoxelMap(cloud, options);
}

/// Keys of the leaves that a ray meets, in its order.
std::vector<std::vector<int>> met_keys(const VoxelMap& map, const Vector3d& origin, const Vector3d& direction,
                                       double distance_m) {
  const LeafRayCaster caster(map, origin, 100.0);
  std::vector<std::vector<int>> keys;
  caster.cast(direction.normalized(), distance_m, [&](uint32_t leaf) {
    const Vector3i key = map.key(map.leaf_layer(), leaf);
    keys.push_back({key.x(), key.y(), key.z()});
  });
  return keys;
}

TEST(LeafRay, MeetsTheLeavesOnItsWayInOrder) {
  const VoxelMap map = metre_map({{2.5, 0.5, 0.5}, {9.5, 0.5, 0.5}, {5.5, 0.5, 0.5}, {5.5, 1.5, 0.5}});
  EXPECT_THAT(met_keys(map, {0.5, 0.5, 0.5}, {1, 0, 0}, 20.0),
              ElementsAre(ElementsAre(2, 0, 0), ElementsAre(5, 0, 0), ElementsAre(9, 0, 0)));
  EXPECT_THAT(met_keys(map, {11.0, 0.5, 0.5}, {-1, 0, 0}, 20.0),
              ElementsAre(ElementsAre(9, 0, 0), ElementsAre(5, 0, 0), ElementsAre(2, 0, 0)));
  EXPECT_THAT(met_keys(map, {0.5, 0.5, 0.5}, {0, 0, 1}, 20.0), IsEmpty());
}

TEST(LeafRay, EndsAtItsDistance) {
  const VoxelMap map = metre_map({{2.5, 0.5, 0.5}, {5.5, 0.5, 0.5}});
  // The second leaf begins 4.5 m away.
  EXPECT_THAT(met_keys(map, {0.5, 0.5, 0.5}, {1, 0, 0}, 4.49), ElementsAre(ElementsAre(2, 0, 0)));
  EXPECT_EQ(met_keys(map, {0.5, 0.5, 0.5}, {1, 0, 0}, 4.51).size(), 2u);
}

TEST(LeafRay, SlantedRayCrossesTheCellsOfAHandDrawing) {
  // y = 0.25 + x / 2 from x = 0: cells (0,0) (1,0) (1,1) (2,1) (3,1) (3,2), also across the origin's root border.
  std::vector<Vector3d> all;
  for (int x = -4; x < 4; ++x) {
    for (int y = -4; y < 4; ++y) all.emplace_back(x + 0.5, y + 0.5, 0.5);
  }
  const VoxelMap map = metre_map(all);
  EXPECT_THAT(met_keys(map, {0.0, 0.25, 0.5}, {1.0, 0.5, 0.0}, 10.0),
              ElementsAre(ElementsAre(0, 0, 0), ElementsAre(1, 0, 0), ElementsAre(1, 1, 0), ElementsAre(2, 1, 0),
                          ElementsAre(3, 1, 0), ElementsAre(3, 2, 0)));
  // y = -0.25 - |x| / 2 towards minus: the mirror image.
  EXPECT_THAT(met_keys(map, {-0.001, -0.25, 0.5}, {-1.0, -0.5, 0.0}, 10.0),
              ElementsAre(ElementsAre(-1, -1, 0), ElementsAre(-2, -1, 0), ElementsAre(-2, -2, 0),
                          ElementsAre(-3, -2, 0), ElementsAre(-4, -2, 0), ElementsAre(-4, -3, 0)));
}

/// Length of the part of the ray's first distance_m inside a cube, negative where it misses.
double chord(const Vector3d& low, double size, const Vector3d& origin, const Vector3d& direction, double distance_m) {
  double enter = 0.0;
  double leave = distance_m;
  for (int a = 0; a < 3; ++a) {
    const double one = (low[a] - origin[a]) / direction[a];
    const double other = (low[a] + size - origin[a]) / direction[a];
    enter = std::max(enter, std::min(one, other));
    leave = std::min(leave, std::max(one, other));
  }
  return leave - enter;
}

TEST(LeafRay, MeetsWhatATestOfEveryLeafFinds) {
  Random random(5);
  for (const double offset : {0.0, 512345.7}) {
    PointCloud cloud;
    cloud.origin = Vector3d::Constant(std::round(offset));
    for (int i = 0; i < 20000; ++i) {
      cloud.positions.emplace_back(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-1, 1));
    }
    const VoxelMap map(cloud, VoxelMapOptions{});
    const double size = map.options().leaf_size_m;
    size_t num_met = 0;
    for (int i = 0; i < 200; ++i) {
      const Vector3d origin =
          cloud.origin + Vector3d(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-2, 2));
      const Vector3d direction = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
      const double distance = random.uniform(0.5, 6.0);
      std::vector<bool> met(map.num_nodes(map.leaf_layer()), false);
      LeafRayCaster(map, origin, 20.0).cast(direction, distance, [&](uint32_t leaf) {
        EXPECT_FALSE(met[leaf]) << "met twice";
        met[leaf] = true;
        ++num_met;
      });
      for (uint32_t leaf = 0; leaf < met.size(); ++leaf) {
        const Vector3d low = map.key(map.leaf_layer(), leaf).cast<double>() * size;
        const double inside = chord(low, size, origin, direction, distance);
        if (std::abs(inside) < 1e-7) continue;  // touches
        EXPECT_EQ(met[leaf], inside > 0.0) << i << " " << inside;
      }
    }
    EXPECT_GT(num_met, 100u);
  }
}

}  // namespace
}  // namespace cpplus
