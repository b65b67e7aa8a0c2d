#include "cpplus/features/leaf_neighbors.h"

#include <gtest/gtest.h>

#include <vector>

#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

TEST(LeafNeighbors, AreThoseOfTheMap) {
  Random random(1);
  PointCloud cloud;
  add_surface({0, 0, 0}, {1, 0.2, 0}, {0, 1, 0.4}, 900, 0.02, &random, &cloud);
  const VoxelMap map(cloud, {});
  const LeafNeighbors neighbors(map);
  std::vector<uint32_t> expected;
  for (uint32_t leaf = 0; leaf < map.num_nodes(map.leaf_layer()); ++leaf) {
    map.neighbors(map.leaf_layer(), leaf, false, &expected);
    EXPECT_EQ(std::vector<uint32_t>(neighbors[leaf].begin(), neighbors[leaf].end()), expected);
  }
}

TEST(LeafNeighbors, ALoneLeafHasNone) {
  PointCloud cloud;
  cloud.positions = {{0.01f, 0.01f, 0.01f}, {5.0f, 5.0f, 5.0f}};
  const LeafNeighbors neighbors(VoxelMap(cloud, {}));
  EXPECT_TRUE(neighbors[0].empty());
  EXPECT_TRUE(neighbors[1].empty());
}

}  // namespace
}  // namespace cpplus
