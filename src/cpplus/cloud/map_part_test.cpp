#include "cpplus/cloud/map_part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;

/// Five points in three roots (0, 1 and 4 along x), of which the middle one holds two.
PointCloud five_points() {
  PointCloud cloud;
  cloud.origin = {100.0, 0.0, 0.0};
  cloud.positions = {
      {8.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}, {3.5f, 0.5f, 0.5f}, {2.5f, 0.5f, 0.5f}, {9.5f, 0.5f, 0.5f}};
  cloud.intensities = {85.0f, 5.0f, 35.0f, 25.0f, 95.0f};
  return cloud;
}

/// Clumps of many points and single ones, with all attributes.
PointCloud random_cloud(size_t num_points) {
  Random random(3);
  PointCloud cloud;
  cloud.origin = {500.0, -30.0, 2.0};
  for (size_t i = 0; i < num_points; ++i) {
    const double spread = i % 3 == 0 ? 40.0 : 3.0;
    const Eigen::Vector3d x(random.uniform(-spread, spread), random.uniform(-spread, spread), random.uniform(-2, 2));
    cloud.positions.push_back(x.cast<float>());
    const auto k = static_cast<uint32_t>(i);
    cloud.intensities.push_back(static_cast<float>(k));
    cloud.colors.push_back({static_cast<uint8_t>(k), static_cast<uint8_t>(k >> 8), 7});
    cloud.stamps_s.push_back(0.5 * k);
    cloud.num_views.push_back(static_cast<uint16_t>(k % 5));
    cloud.best_images.push_back(3 * k);
    cloud.color_spreads.push_back(static_cast<uint8_t>(k % 11));
  }
  return cloud;
}

/// The points of these roots alone, in the order of the cloud.
PointCloud points_in_roots(const PointCloud& cloud, const PointMap& points, std::span<const uint32_t> roots) {
  std::vector<uint32_t> wanted;
  for (const uint32_t root : roots) {
    for (uint32_t i = points.map.points_begin(0, root); i < points.map.points_end(0, root); ++i) {
      wanted.push_back(points.map.input_index(i));
    }
  }
  std::sort(wanted.begin(), wanted.end());
  PointCloud some;
  some.origin = cloud.origin;
  for (const uint32_t i : wanted) {
    some.positions.push_back(cloud.positions[i]);
    some.intensities.push_back(cloud.intensities[i]);
    some.colors.push_back(cloud.colors[i]);
    some.stamps_s.push_back(cloud.stamps_s[i]);
    some.num_views.push_back(cloud.num_views[i]);
    some.best_images.push_back(cloud.best_images[i]);
    some.color_spreads.push_back(cloud.color_spreads[i]);
  }
  return some;
}

void expect_same_layers(const VoxelMap& a, const VoxelMap& b) {
  ASSERT_EQ(a.num_layers(), b.num_layers());
  for (size_t l = 0; l < a.arrays().layers.size(); ++l) {
    const VoxelMapLayer &of_a = a.arrays().layers[l], &of_b = b.arrays().layers[l];
    EXPECT_THAT(of_a.first, ElementsAreArray(of_b.first)) << l;
    EXPECT_THAT(of_a.child_mask, ElementsAreArray(of_b.child_mask)) << l;
    EXPECT_THAT(of_a.moments_mask, ElementsAreArray(of_b.moments_mask)) << l;
    EXPECT_THAT(of_a.moments_rank, ElementsAreArray(of_b.moments_rank)) << l;
    ASSERT_EQ(of_a.moments.size(), of_b.moments.size()) << l;
    for (size_t k = 0; k < of_a.moments.size(); ++k) {
      EXPECT_EQ(of_a.moments[k].mean, of_b.moments[k].mean);
      EXPECT_EQ(of_a.moments[k].covariance, of_b.moments[k].covariance);
    }
  }
}

TEST(MapPart, RootsNearPlacesByHand) {
  const PointMap points = make_point_map(five_points(), {});
  // Roots cover x in [100, 102), [102, 104) and [108, 110).
  const std::vector<Eigen::Vector3d> before = {{98.0, 1.0, 1.0}};
  EXPECT_THAT(roots_near(points.map, before, 1.9), IsEmpty());
  EXPECT_THAT(roots_near(points.map, before, 2.1), ElementsAre(0));
  EXPECT_THAT(roots_near(points.map, before, 4.1), ElementsAre(0, 1));
  const std::vector<Eigen::Vector3d> both = {{111.0, 1.0, 1.0}, {98.0, 1.0, 1.0}};
  EXPECT_THAT(roots_near(points.map, both, 2.1), ElementsAre(0, 2));
  EXPECT_THAT(roots_near(points.map, {}, 1e3), IsEmpty());
  EXPECT_THAT(roots_near(make_point_map({}, {}).map, both, 1e3), IsEmpty());
}

TEST(MapPart, HoldsItsPointsAloneInTheOrderOfTheInput) {
  const PointMap points = make_point_map(five_points(), {});
  const std::vector<uint32_t> roots = {1, 2};
  const PointMap part = part_of_map(points, roots);
  EXPECT_THAT(part.intensities, ElementsAre(25.0f, 35.0f, 85.0f, 95.0f));
  // In the input: 85, 35, 25, 95.
  EXPECT_THAT(part.map.arrays().input_indices, ElementsAre(2, 1, 0, 3));
  EXPECT_EQ(part.map.point(0), Eigen::Vector3d(102.5, 0.5, 0.5));
  EXPECT_TRUE(part.map.find_leaf({103.5, 0.5, 0.5}).has_value());
  EXPECT_FALSE(part.map.find_leaf({100.5, 0.5, 0.5}).has_value());
  EXPECT_THAT(cloud_in_input_order(part).intensities, ElementsAre(85.0f, 35.0f, 25.0f, 95.0f));
}

TEST(MapPart, IsTheMapOfItsPoints) {
  const PointCloud cloud = random_cloud(20000);
  const PointMap points = make_point_map(cloud, {});
  const std::vector<Eigen::Vector3d> places = {{500.0, -30.0, 2.0}, {520.0, -10.0, 2.0}, {470.0, -35.0, 2.0}};
  const std::vector<uint32_t> roots = roots_near(points.map, places, 6.0);
  ASSERT_GT(roots.size(), 100u);
  ASSERT_LT(roots.size(), points.map.num_nodes(0) / 2);
  const PointMap part = part_of_map(points, roots);
  const PointMap built = make_point_map(points_in_roots(cloud, points, roots), {});
  EXPECT_THAT(part.map.positions(), ElementsAreArray(built.map.positions()));
  EXPECT_THAT(part.map.arrays().input_indices, ElementsAreArray(built.map.arrays().input_indices));
  EXPECT_THAT(part.map.arrays().root_keys, ElementsAreArray(built.map.arrays().root_keys));
  EXPECT_THAT(part.map.arrays().root_table, ElementsAreArray(built.map.arrays().root_table));
  expect_same_layers(part.map, built.map);
  EXPECT_THAT(part.intensities, ElementsAreArray(built.intensities));
  EXPECT_THAT(part.colors, ElementsAreArray(built.colors));
  EXPECT_THAT(part.stamps_s, ElementsAreArray(built.stamps_s));
  EXPECT_THAT(part.num_views, ElementsAreArray(built.num_views));
  EXPECT_THAT(part.best_images, ElementsAreArray(built.best_images));
  EXPECT_THAT(part.color_spreads, ElementsAreArray(built.color_spreads));
}

TEST(MapPart, AllRootsAreTheMapItself) {
  const PointMap points = make_point_map(five_points(), {});
  const std::vector<uint32_t> roots = {0, 1, 2};
  const PointMap part = part_of_map(points, roots);
  EXPECT_EQ(part.map.positions().data(), points.map.positions().data()) << "nothing is copied";
  EXPECT_EQ(part.intensities.data(), points.intensities.data());
}

TEST(MapPart, NoRootsAreAnEmptyMap) {
  const PointMap part = part_of_map(make_point_map(five_points(), {}), {});
  EXPECT_EQ(part.map.num_points(), 0u);
  EXPECT_EQ(part.map.num_nodes(0), 0u);
  EXPECT_EQ(part.map.num_nodes(part.map.leaf_layer()), 0u);
  EXPECT_FALSE(part.map.find_leaf({100.5, 0.5, 0.5}).has_value());
  EXPECT_THAT(part.map.roots_in_radius({100.5, 0.5, 0.5}, 10.0), IsEmpty());
}

TEST(MapPart, DamagedIndicesAreRefused) {
  const PointMap points = make_point_map(five_points(), {});
  for (const uint32_t wrong : {0u, 5u}) {  // one twice, one too large
    std::vector<uint32_t> indices(points.map.arrays().input_indices.begin(), points.map.arrays().input_indices.end());
    indices.back() = wrong;
    VoxelMapArrays arrays = points.map.arrays();
    arrays.input_indices = indices;
    PointMap damaged = points;
    damaged.map = VoxelMap(points.map.origin(), points.map.options(), arrays);
    const std::vector<uint32_t> roots = {1, 2};
    EXPECT_THROW(part_of_map(damaged, roots), Error) << wrong;
  }
}

}  // namespace
}  // namespace cpplus
