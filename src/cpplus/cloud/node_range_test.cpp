#include "cpplus/cloud/node_range.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(NodeRange, LeavesOfRootsFollowEachOther) {
  PointCloud cloud;
  cloud.positions = {{0.1f, 0.1f, 0.1f}, {1.9f, 0.1f, 0.1f}, {1.91f, 0.1f, 0.1f}, {2.1f, 0.1f, 0.1f}};
  const VoxelMap map(cloud, {});
  EXPECT_EQ(leaves_of(map, 0, 0), (NodeRange{0, 2}));
  EXPECT_EQ(leaves_of(map, 0, 1), (NodeRange{2, 3}));
  EXPECT_EQ(descendants_of(map, 0, 1, 0), (NodeRange{1, 2}));
  EXPECT_EQ(leaves_of(map, map.leaf_layer(), 2).size(), 1u);
}

}  // namespace
}  // namespace cpplus
