#include "cpplus/dynamics/near_nodes.h"

#include <gmock/gmock.h>

namespace cpplus {
namespace {

TEST(WithNodesAround, TheNodeItselfAndThoseThatTouchIt) {
  PointCloud cloud;
  for (const float x : {0.03f, 0.09f, 0.16f, 1.03f}) cloud.positions.emplace_back(x, 0.03f, 0.03f);
  const VoxelMap map(cloud, {});
  const int layer = map.leaf_layer();
  ASSERT_EQ(map.num_nodes(layer), 4u);
  EXPECT_THAT(with_nodes_around(map, layer, {1, 0, 0, 0}), testing::ElementsAre(1, 1, 0, 0));
  EXPECT_THAT(with_nodes_around(map, layer, {0, 1, 0, 0}), testing::ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(with_nodes_around(map, layer, {0, 0, 0, 1}), testing::ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(with_nodes_around(map, layer, {0, 0, 0, 0}), testing::Each(0));
}

TEST(NodesNearDynamic, OfALayerAboveTheLeaves) {
  PointCloud cloud;
  for (const float x : {0.03f, 0.09f, 0.16f, 0.22f, 1.03f}) cloud.positions.emplace_back(x, 0.03f, 0.03f);
  const VoxelMap map(cloud, {});
  const int layer = map.leaf_layer() - 1;  // 12.5 cm: two leaves, two leaves, one
  ASSERT_EQ(map.num_nodes(layer), 3u);
  EXPECT_THAT(nodes_near_dynamic(map, layer, {0, 1, 0, 0, 0}), testing::ElementsAre(1, 1, 0));
  EXPECT_THAT(nodes_near_dynamic(map, layer, {0, 0, 0, 0, 1}), testing::ElementsAre(0, 0, 1));
  EXPECT_THAT(nodes_near_dynamic(map, layer, {0, 0, 0, 0, 0}), testing::Each(0));
}

}  // namespace
}  // namespace cpplus
