#include "cpplus/report/point_tiles.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace cpplus {
namespace {

struct Scene {
  PointCloud cloud;
  VoxelMap map;
  std::vector<uint8_t> is_colored;
};

// A floor of 24 x 24 m at UTM coordinates, red where x is below the middle and else green; roots of 8 m, leaves of 1 m.
Scene make_scene() {
  Scene scene;
  scene.cloud.origin = {600000, 5000000, 100};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> along(0.0f, 24.0f);
  for (int i = 0; i < 4000; ++i) {
    scene.cloud.positions.emplace_back(along(random), along(random), 0.5f);
    scene.cloud.colors.push_back(scene.cloud.positions.back().x() < 12.0f ? Rgb{200, 0, 0} : Rgb{0, 200, 0});
  }
  VoxelMapOptions options;
  options.root_size_m = 8.0;
  options.leaf_size_m = 1.0;
  scene.map = VoxelMap(scene.cloud, options);
  scene.is_colored.assign(scene.cloud.size(), 1);
  return scene;
}

const PointTileOptions kOptions = {100, 4};

TEST(PointTiles, LeavesHoldEveryPointOnce) {
  const Scene scene = make_scene();
  const std::vector<PointTile> tiles = plan_point_tiles(scene.map, kOptions);
  size_t num_points = 0;
  std::set<uint32_t> children;
  for (const PointTile& tile : tiles) {
    EXPECT_EQ(tile.children.empty(), tile.spacing_m == 0.0);
    for (uint32_t child : tile.children) {
      EXPECT_TRUE(children.insert(child).second);
      EXPECT_EQ(tiles[child].size_m * 2.0, tile.size_m);
    }
    if (!tile.children.empty()) continue;
    num_points +=
        gather_tile_points(scene.map, tile, scene.cloud.colors, scene.is_colored, scene.cloud.origin).positions.size();
  }
  EXPECT_EQ(num_points, scene.cloud.size());
  EXPECT_EQ(children.size() + 1, tiles.size());  // all but the last, which holds everything
  EXPECT_EQ(children.count(static_cast<uint32_t>(tiles.size() - 1)), 0u);
}

TEST(PointTiles, CoarseTilesLieInTheirCubeAndKeepPlaceAndColor) {
  const Scene scene = make_scene();
  for (const PointTile& tile : plan_point_tiles(scene.map, kOptions)) {
    const TilePoints points =
        gather_tile_points(scene.map, tile, scene.cloud.colors, scene.is_colored, scene.cloud.origin);
    ASSERT_FALSE(points.positions.empty());
    if (tile.spacing_m > 0.0) {
      EXPECT_EQ(tile.size_m / 4, tile.spacing_m);
      EXPECT_LE(points.positions.size(), 16u);
    }
    const Eigen::Vector3d low = tile.corner_in_map - scene.cloud.origin;
    for (size_t i = 0; i < points.positions.size(); ++i) {
      const Eigen::Vector3d& x = points.positions[i];
      EXPECT_NEAR(x.z(), 0.5, 1e-6);
      EXPECT_TRUE(((x - low).array() >= -1e-3).all() && ((x - low).array() <= tile.size_m + 1e-3).all());
      // Voxels of up to 4 m do not reach over the middle.
      if (tile.spacing_m <= 4.0) {
        EXPECT_EQ(points.colors[i], x.x() < 12.0 ? (Rgb{200, 0, 0}) : (Rgb{0, 200, 0}));
      }
    }
  }
}

TEST(PointTiles, JoinsRootsOnBothSidesOfTheOrigin) {
  PointCloud cloud;
  cloud.positions = {{-1.0f, -1.0f, -1.0f}, {1.0f, 1.0f, 1.0f}, {9.0f, 1.0f, -5.0f}};
  cloud.colors.resize(3);
  VoxelMapOptions options;
  options.root_size_m = 4.0;
  options.leaf_size_m = 1.0;
  const VoxelMap map(cloud, options);
  const PointTile top = plan_point_tiles(map, {1, 4}).back();
  EXPECT_EQ(top.nodes.size(), 3u);
  for (const Eigen::Vector3f& x : cloud.positions) {
    const Eigen::Vector3d inside = x.cast<double>() - top.corner_in_map;
    EXPECT_TRUE((inside.array() >= 0.0).all() && (inside.array() <= top.size_m).all());
  }
}

TEST(PointTiles, PointsWithoutColorDoNotDarkenOthers) {
  PointCloud cloud;
  cloud.positions = {{0.1f, 0.1f, 0.1f}, {0.3f, 0.1f, 0.1f}};
  cloud.colors = {{90, 80, 70}, {0, 0, 0}};
  VoxelMapOptions options;
  options.root_size_m = 4.0;
  options.leaf_size_m = 1.0;
  const VoxelMap map(cloud, options);
  const std::vector<PointTile> tiles = plan_point_tiles(map, {1, 4});
  const TilePoints coarse = gather_tile_points(map, tiles.back(), cloud.colors, {1, 0}, Eigen::Vector3d::Zero());
  ASSERT_EQ(coarse.colors.size(), 1u);
  EXPECT_EQ(coarse.colors[0], (Rgb{90, 80, 70}));
  EXPECT_NEAR(coarse.positions[0].x(), 0.2, 1e-6);
}

}  // namespace
}  // namespace cpplus
