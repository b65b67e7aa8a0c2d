#include "cpplus/cloud/map_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace cpplus {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// One point in each root of a rectangle, 2 m apart.
VoxelMap rectangle_of_roots(int num_x, int num_y) {
  PointCloud cloud;
  for (int x = 0; x < num_x; ++x) {
    for (int y = 0; y < num_y; ++y) {
      cloud.positions.emplace_back(2.0f * static_cast<float>(x) + 1.0f, 2.0f * static_cast<float>(y) + 1.0f, 1.0f);
    }
  }
  return VoxelMap(cloud, {});
}

TEST(MapTiles, ASmallMapIsOneTileOfAllSpace) {
  const auto tiles = divide_map(rectangle_of_roots(2, 2), 4);
  ASSERT_EQ(tiles.size(), 1u);
  EXPECT_THAT(tiles[0].roots, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(tiles[0].box.min().maxCoeff(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(tiles[0].box.max().minCoeff(), std::numeric_limits<double>::infinity());
  EXPECT_THAT(divide_map(VoxelMap(), 4), IsEmpty());
}

TEST(MapTiles, AreHalvedAcrossTheLongestExtentButNotToLessThanFourRoots) {
  const auto tiles = divide_map(rectangle_of_roots(9, 2), 1);
  ASSERT_EQ(tiles.size(), 2u);
  EXPECT_THAT(tiles[0].roots, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_EQ(tiles[0].box.max().x(), 8.0);
  EXPECT_EQ(tiles[1].box.min().x(), 8.0);
  EXPECT_EQ(tiles[1].box.max().x(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(tiles[1].roots.size(), 10u);
}

TEST(MapTiles, HoldEveryRootOnceInTheirBoxes) {
  const VoxelMap map = rectangle_of_roots(20, 13);
  const auto tiles = divide_map(map, 30);
  EXPECT_GT(tiles.size(), 4u);
  std::vector<uint32_t> all;
  for (const MapTile& tile : tiles) {
    EXPECT_TRUE(std::is_sorted(tile.roots.begin(), tile.roots.end()));
    for (const uint32_t root : tile.roots) EXPECT_TRUE(tile.box.contains(map.center(0, root))) << root;
    all.insert(all.end(), tile.roots.begin(), tile.roots.end());
  }
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), map.num_nodes(0));
  EXPECT_EQ(std::unique(all.begin(), all.end()), all.end());
}

TEST(MapTiles, RootsAroundAreThoseWithinTheHalo) {
  const VoxelMap map = rectangle_of_roots(3, 20);
  const auto tiles = divide_map(map, 30);
  ASSERT_EQ(tiles.size(), 2u);
  for (const double halo_m : {2.0, 3.0}) {
    const auto around = roots_around(map, tiles[1], halo_m);
    const int rows = halo_m > 2.0 ? 12 : 11;
    EXPECT_EQ(around.size(), 3u * static_cast<size_t>(rows));
    for (const uint32_t root : around) EXPECT_GT(map.center(0, root).y(), 2.0 * (20 - rows));
  }
}

}  // namespace
}  // namespace cpplus
