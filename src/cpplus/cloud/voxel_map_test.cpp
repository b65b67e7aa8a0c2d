#include "cpplus/cloud/voxel_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Key = std::array<int, 3>;
Key to_array(const Eigen::Vector3i& key) { return {key.x(), key.y(), key.z()}; }

PointCloud cloud_of(const std::vector<Eigen::Vector3f>& positions) {
  PointCloud cloud;
  cloud.positions = positions;
  return cloud;
}

/// Three noisy walls around the origin and some loose points, in random order.
PointCloud random_cloud(size_t size, uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  for (size_t i = 0; i < size; ++i) {
    Eigen::Vector3d x(random.uniform(-6, 7), random.uniform(-5, 5), random.uniform(-3, 4));
    if (i % 20 != 0) x[static_cast<int>(i % 3)] = 0.013 * random.normal();
    cloud.positions.push_back(x.cast<float>());
  }
  return cloud;
}

/// Points of each voxel of a layer in input order, by dividing and rounding each coordinate.
std::map<Key, std::vector<uint32_t>> voxels_by_division(const PointCloud& cloud, double voxel_size) {
  std::map<Key, std::vector<uint32_t>> voxels;
  for (uint32_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d cell = (cloud.point(i) / voxel_size).array().floor();
    voxels[{static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())}].push_back(i);
  }
  return voxels;
}

VoxelStatistics statistics_of(const PointCloud& cloud, const std::vector<uint32_t>& indices) {
  VoxelStatistics s;
  s.count = indices.size();
  for (uint32_t i : indices) s.mean += (cloud.point(i) - cloud.point(indices[0])) / static_cast<double>(s.count);
  s.mean += cloud.point(indices[0]);
  for (uint32_t i : indices) {
    s.covariance += (cloud.point(i) - s.mean) * (cloud.point(i) - s.mean).transpose() / static_cast<double>(s.count);
  }
  return s;
}

/// Every node of every layer against the division of all points; `mean_tolerance` in metres.
void expect_equals_division(const VoxelMap& map, const PointCloud& cloud, double mean_tolerance) {
  for (int layer = 0; layer < map.num_layers(); ++layer) {
    const auto voxels = voxels_by_division(cloud, map.voxel_size(layer));
    ASSERT_EQ(map.num_nodes(layer), voxels.size()) << "layer " << layer;
    for (uint32_t node = 0; node < map.num_nodes(layer); ++node) {
      const auto voxel = voxels.find(to_array(map.key(layer, node)));
      ASSERT_NE(voxel, voxels.end());
      std::vector<uint32_t> indices;
      for (uint32_t i = map.points_begin(layer, node); i < map.points_end(layer, node); ++i) {
        indices.push_back(map.input_index(i));
        ASSERT_EQ(map.positions()[i], cloud.positions[map.input_index(i)]);
      }
      if (layer < map.leaf_layer()) std::sort(indices.begin(), indices.end());
      ASSERT_EQ(indices, voxel->second);  // leaves keep the order of the input
      ASSERT_EQ(map.find(layer, map.key(layer, node)), node);

      const VoxelStatistics expected = statistics_of(cloud, voxel->second);
      const VoxelStatistics got = map.statistics(layer, node);
      ASSERT_EQ(got.count, expected.count);
      ASSERT_LT((got.mean - expected.mean).norm(), mean_tolerance);
      ASSERT_LT((got.covariance - expected.covariance).norm(), 1e-6 * expected.covariance.norm() + 1e-12);
    }
  }
}

TEST(VoxelMap, HandComputed) {
  // Roots of 1 m, leaves of 0.25 m. Leaf (0,0,0) holds points 1 and 3, leaf (3,0,0) point 0, root (-1,0,0) point 2.
  const PointCloud cloud = cloud_of({{0.9f, 0.1f, 0.1f}, {0.0f, 0.0f, 0.0f}, {-0.1f, 0.9f, 0.3f}, {0.2f, 0.1f, 0.0f}});
  const VoxelMap map(cloud, {.root_size_m = 1.0, .leaf_size_m = 0.25});

  ASSERT_EQ(map.num_layers(), 3);
  EXPECT_EQ(map.voxel_size(1), 0.5);
  ASSERT_EQ(map.num_nodes(0), 2u);
  ASSERT_EQ(map.num_nodes(1), 3u);
  ASSERT_EQ(map.num_nodes(2), 3u);
  EXPECT_EQ(map.key(0, 0), Eigen::Vector3i(-1, 0, 0));
  EXPECT_EQ(map.key(1, 0), Eigen::Vector3i(-1, 1, 0));
  EXPECT_EQ(map.key(2, 0), Eigen::Vector3i(-1, 3, 1));
  EXPECT_EQ(map.key(2, 1), Eigen::Vector3i(0, 0, 0));
  EXPECT_EQ(map.key(2, 2), Eigen::Vector3i(3, 0, 0));
  EXPECT_EQ(map.center(2, 2), Eigen::Vector3d(0.875, 0.125, 0.125));

  std::vector<uint32_t> order;
  for (uint32_t i = 0; i < 4; ++i) order.push_back(map.input_index(i));
  EXPECT_THAT(order, ElementsAre(2, 1, 3, 0));
  EXPECT_EQ(map.points_begin(0, 1), 1u);
  EXPECT_EQ(map.points_end(0, 1), 4u);
  EXPECT_EQ(map.children_begin(0, 1), 1u);
  EXPECT_EQ(map.children_end(0, 1), 3u);
  EXPECT_EQ(map.parent(2, 2), 2u);
  EXPECT_EQ(map.parent(1, 2), 1u);

  const VoxelStatistics s = map.statistics(2, 1);
  EXPECT_EQ(s.count, 2u);
  EXPECT_NEAR((s.mean - Eigen::Vector3d(0.1, 0.05, 0.0)).norm(), 0.0, 1e-8);
  EXPECT_NEAR(s.covariance(0, 0), 0.01, 1e-9);
  EXPECT_NEAR(s.covariance(0, 1), 0.005, 1e-9);
  EXPECT_NEAR(s.covariance(1, 1), 0.0025, 1e-9);
  EXPECT_EQ(s.covariance(2, 2), 0.0);
}

TEST(VoxelMap, EqualsDivisionOnRandomCloud) {
  const PointCloud cloud = random_cloud(30000, 1);
  expect_equals_division(VoxelMap(cloud, VoxelMapOptions()), cloud, 1e-7);
}

TEST(VoxelMap, EqualsDivisionWithOtherSizes) {
  const PointCloud cloud = random_cloud(8000, 2);
  expect_equals_division(VoxelMap(cloud, {.root_size_m = 0.5, .leaf_size_m = 0.5}), cloud, 1e-7);
  expect_equals_division(VoxelMap(cloud, {.root_size_m = 64.0, .leaf_size_m = 0.0625}), cloud, 4e-6);
}

TEST(VoxelMap, PointsOnBordersBelongToTheUpperVoxel) {
  std::vector<Eigen::Vector3f> positions;
  for (int i = -40; i <= 40; ++i) {
    const float border = 0.0625f * static_cast<float>(i);
    for (float x : {std::nextafter(border, -10.0f), border, std::nextafter(border, 10.0f)}) {
      positions.push_back({x, -x, border});
    }
  }
  const PointCloud cloud = cloud_of(positions);
  const VoxelMap map(cloud, VoxelMapOptions());
  expect_equals_division(map, cloud, 1e-7);
  EXPECT_EQ(map.key_of(map.leaf_layer(), Eigen::Vector3d(-0.0625, 0.0, 2.0)), Eigen::Vector3i(-1, 0, 32));
  EXPECT_EQ(map.key_of(0, Eigen::Vector3d(-2.0, -1e-12, 2.0)), Eigen::Vector3i(-1, -1, 1));
}

TEST(VoxelMap, NegativeZeroIsZero) {
  PointCloud cloud = cloud_of({{-0.0f, -0.0f, -0.0f}, {-1e-38f, 1e-38f, 0.0f}});
  cloud.origin = Eigen::Vector3d(-0.0, -0.0, -0.0);
  const VoxelMap map(cloud, VoxelMapOptions());
  ASSERT_EQ(map.num_nodes(map.leaf_layer()), 2u);
  EXPECT_EQ(map.key(0, 0), Eigen::Vector3i(-1, 0, 0));
  EXPECT_EQ(map.key(0, 1), Eigen::Vector3i(0, 0, 0));
  EXPECT_EQ(map.find_leaf(Eigen::Vector3d(-0.0, -0.0, -0.0)), 1u);
}

TEST(VoxelMap, KeepsUtmCoordinates) {
  PointCloud cloud = random_cloud(20000, 3);
  cloud.origin = Eigen::Vector3d(448262.123456, 5411932.654321, 112.5);
  const VoxelMap map(cloud, VoxelMapOptions());
  expect_equals_division(map, cloud, 1e-7);
  EXPECT_EQ(map.origin(), cloud.origin);
  EXPECT_EQ(map.point(17), cloud.point(map.input_index(17)));
}

TEST(VoxelMap, ParentStatisticsAreTheSumOfTheChildren) {
  const VoxelMap map(random_cloud(40000, 4), VoxelMapOptions());
  for (int layer = 0; layer < map.leaf_layer(); ++layer) {
    uint32_t next = 0;
    for (uint32_t node = 0; node < map.num_nodes(layer); ++node) {
      const VoxelStatistics parent = map.statistics(layer, node);
      ASSERT_EQ(map.children_begin(layer, node), next);
      VoxelStatistics sum;
      Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
      for (; next < map.children_end(layer, node); ++next) {
        ASSERT_EQ(map.parent(layer + 1, next), node);
        const VoxelStatistics child = map.statistics(layer + 1, next);
        const double weight = static_cast<double>(child.count);
        const Eigen::Vector3d d = child.mean - parent.mean;
        sum.count += child.count;
        sum.mean += weight * d;
        scatter += weight * (child.covariance + d * d.transpose());
      }
      const double count = static_cast<double>(parent.count);
      ASSERT_EQ(sum.count, parent.count);
      ASSERT_LT(sum.mean.norm() / count, 2e-7);
      ASSERT_LT((scatter / count - parent.covariance).norm(), 1e-6 * parent.covariance.norm() + 1e-12);
    }
    ASSERT_EQ(next, map.num_nodes(layer + 1));
  }
}

TEST(VoxelMap, StatisticsOfAThinPlaneFarAwayKeepTheThickness) {
  Random random(5);
  PointCloud cloud;
  cloud.origin = Eigen::Vector3d(5e5, 5.4e6, 0.0);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d x(random.uniform(0.1, 1.9), random.uniform(0.1, 1.9), 1.01 + 0.001 * random.normal());
    cloud.positions.push_back(x.cast<float>());
  }
  const VoxelMap map(cloud, VoxelMapOptions());
  ASSERT_EQ(map.num_nodes(0), 1u);
  EXPECT_NEAR(std::sqrt(map.statistics(0, 0).covariance(2, 2)), 0.001, 0.00002);
}

template <typename T>
void expect_same_bits(std::span<const T> a, std::span<const T> b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
}

TEST(VoxelMap, IsTheSameForAnyNumberOfThreads) {
  const PointCloud cloud = random_cloud(300000, 6);
  set_num_threads(1);
  const VoxelMap one(cloud, VoxelMapOptions());
  set_num_threads(2);
  const VoxelMap two(cloud, VoxelMapOptions());
  set_num_threads(0);
  expect_same_bits(one.positions(), two.positions());
  for (size_t i = 0; i < cloud.size(); ++i) ASSERT_EQ(one.input_index(i), two.input_index(i));
  for (int layer = 0; layer < one.num_layers(); ++layer) {
    ASSERT_EQ(one.num_nodes(layer), two.num_nodes(layer));
    for (uint32_t node = 0; node < one.num_nodes(layer); ++node) {
      ASSERT_EQ(one.points_begin(layer, node), two.points_begin(layer, node));
      ASSERT_EQ(one.key(layer, node), two.key(layer, node));
      ASSERT_EQ(one.statistics(layer, node).mean, two.statistics(layer, node).mean);
      ASSERT_EQ(one.statistics(layer, node).covariance, two.statistics(layer, node).covariance);
    }
  }
}

TEST(VoxelMap, NeighborsEqualLookupsInEveryLayer) {
  const VoxelMap map(random_cloud(15000, 7), VoxelMapOptions());
  std::vector<uint32_t> got = {99};
  for (int layer = 0; layer < map.num_layers(); ++layer) {
    for (uint32_t node = 0; node < map.num_nodes(layer); ++node) {
      for (bool faces_only : {false, true}) {
        std::vector<uint32_t> expected;
        for (int n = 0; n < 27; ++n) {
          const Eigen::Vector3i d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
          if (n == 13 || (faces_only && d.cwiseAbs().sum() > 1)) continue;
          if (const auto found = map.find(layer, map.key(layer, node) + d)) expected.push_back(*found);
        }
        std::sort(expected.begin(), expected.end());
        map.neighbors(layer, node, faces_only, &got);
        ASSERT_EQ(got, expected) << "layer " << layer << " node " << node;
      }
    }
  }
}

TEST(VoxelMap, FindsOnlyWhatExists) {
  const PointCloud cloud = random_cloud(3000, 8);
  const VoxelMap map(cloud, VoxelMapOptions());
  const auto leaves = voxels_by_division(cloud, 0.0625);
  Random random(9);
  size_t num_empty = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d x(random.uniform(-8, 8), random.uniform(-8, 8), random.uniform(-8, 8));
    const Eigen::Vector3i cell = map.key_of(map.leaf_layer(), x);
    const auto found = map.find_leaf(x);
    ASSERT_EQ(found.has_value(), leaves.count(to_array(cell)) > 0);
    num_empty += found ? 0 : 1;
    const auto lowest = map.find_lowest(cell);
    ASSERT_EQ(lowest.has_value(), map.find(0, map.key_of(0, x)).has_value());
    if (!lowest) continue;
    ASSERT_EQ(map.key(lowest->layer, lowest->index), map.key_of(lowest->layer, x));
    if (lowest->layer < map.leaf_layer()) {
      ASSERT_FALSE(map.find(lowest->layer + 1, map.key_of(lowest->layer + 1, x)));
    }
  }
  EXPECT_GT(num_empty, 10000u);
  for (uint32_t i = 0; i < map.num_points(); ++i) {
    const auto leaf = map.find_leaf(map.point(i));
    ASSERT_TRUE(leaf);
    ASSERT_LE(map.points_begin(map.leaf_layer(), *leaf), i);
    ASSERT_LT(i, map.points_end(map.leaf_layer(), *leaf));
  }
  EXPECT_FALSE(map.find_leaf(Eigen::Vector3d(1e300, 0, 0)));
  EXPECT_FALSE(map.find_leaf(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())));
}

TEST(VoxelMap, RootsInRadius) {
  const VoxelMap map(random_cloud(20000, 10), VoxelMapOptions());
  for (const Eigen::Vector3d& x : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-5, 3, 1), Eigen::Vector3d(30, 0, 0)}) {
    for (double radius : {0.0, 1.0, 2.5, 7.0, 28.0, 1e12}) {
      std::vector<uint32_t> expected;
      for (uint32_t root = 0; root < map.num_nodes(0); ++root) {
        const Eigen::Vector3d low = map.key(0, root).cast<double>() * 2.0;
        const Eigen::Vector3d nearest = x.cwiseMax(low).cwiseMin((low.array() + 2.0).matrix());
        if ((nearest - x).norm() <= radius) expected.push_back(root);
      }
      EXPECT_EQ(map.roots_in_radius(x, radius), expected) << "radius " << radius;
    }
  }
}

TEST(VoxelMap, RootsInFrustumKeepEveryPointInTheCone) {
  const VoxelMap map(random_cloud(20000, 11), VoxelMapOptions());
  const Eigen::Vector3d apex(0.3, -0.2, 0.5);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.2, -0.1).normalized();
  for (double half_angle : {0.1, 0.6, 1.8, 3.14159265}) {
    const auto roots = map.roots_in_frustum(apex, axis, half_angle, 5.0);
    ASSERT_TRUE(std::is_sorted(roots.begin(), roots.end()));
    std::vector<bool> kept(map.num_nodes(0), false);
    for (uint32_t root : roots) kept[root] = true;
    for (uint32_t root = 0; root < map.num_nodes(0); ++root) {
      for (uint32_t i = map.points_begin(0, root); i < map.points_end(0, root); ++i) {
        const Eigen::Vector3d d = map.point(i) - apex;
        const bool in_cone = d.norm() < 5.0 && std::acos(d.normalized().dot(axis)) < half_angle;
        ASSERT_TRUE(kept[root] || !in_cone);
      }
    }
  }
  EXPECT_EQ(map.roots_in_frustum(apex, axis, 3.14159265, 5.0), map.roots_in_radius(apex, 5.0));
  // A root 3 m behind the camera is not in a narrow cone.
  const auto narrow = map.roots_in_frustum(apex, axis, 0.1, 5.0);
  const auto behind = map.find(0, Eigen::Vector3i(-2, 0, 0));
  ASSERT_TRUE(behind);
  EXPECT_FALSE(std::binary_search(narrow.begin(), narrow.end(), *behind));
}

TEST(VoxelMap, EmptyCloud) {
  const VoxelMap map(PointCloud{}, VoxelMapOptions{});
  EXPECT_EQ(map.num_layers(), 6);
  EXPECT_EQ(map.num_points(), 0u);
  for (int layer = 0; layer < 6; ++layer) EXPECT_EQ(map.num_nodes(layer), 0u);
  EXPECT_FALSE(map.find(3, Eigen::Vector3i(1, 2, 3)));
  EXPECT_FALSE(map.find_lowest(Eigen::Vector3i(1, 2, 3)));
  EXPECT_TRUE(map.roots_in_radius(Eigen::Vector3d::Zero(), 1e3).empty());
}

TEST(VoxelMap, DropsAndCountsNonFinitePoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const VoxelMap map(cloud_of({{nan, 0, 0}, {1, 2, 3}, {0, inf, 0}, {0, 0, -inf}, {4, 5, 6}}), VoxelMapOptions());
  EXPECT_EQ(map.num_dropped(), 3u);
  ASSERT_EQ(map.num_points(), 2u);
  EXPECT_EQ(map.input_index(0), 1u);
  EXPECT_EQ(map.input_index(1), 4u);
  const VoxelMap none(cloud_of({{nan, nan, nan}}), VoxelMapOptions());
  EXPECT_EQ(none.num_points(), 0u);
  EXPECT_EQ(none.num_dropped(), 1u);
}

TEST(VoxelMap, KeepsFarOutliers) {
  const PointCloud cloud = cloud_of({{0, 0, 0}, {1e7f, -1e7f, 5}, {-6e7f, 6e7f, -6e7f}, {1, 1, 1}});
  const VoxelMap map(cloud, VoxelMapOptions());
  EXPECT_EQ(map.num_nodes(0), 3u);
  const auto far = map.find_leaf(Eigen::Vector3d(1e7, -1e7, 5));
  ASSERT_TRUE(far);
  EXPECT_EQ(map.key(map.leaf_layer(), *far), Eigen::Vector3i(160000000, -160000000, 80));
}

TEST(VoxelMap, RefusesPointsBeyondTheGrid) {
  // The limit is 2^30 leaves: 67,108,864 m for leaves of 62.5 mm.
  const float inside = std::nextafter(67108864.0f, 0.0f);
  EXPECT_NO_THROW(VoxelMap(cloud_of({{0, inside, -inside}}), VoxelMapOptions()));
  try {
    const VoxelMap map(cloud_of({{0, 0, 0}, {1, -67108864.0f, 2}, {1e30f, 0, 0}}), VoxelMapOptions());
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("point 1 at (1, -67108864, 2) m"));
  }
  PointCloud cloud = cloud_of({{0, 0, 0}});
  cloud.origin.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(VoxelMap(cloud, VoxelMapOptions()), Error);
}

TEST(VoxelMap, RefusesBadOptions) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const VoxelMapOptions& bad : std::vector<VoxelMapOptions>{
           {0.0, 0.1}, {2.0, 0.0}, {2.0, -0.5}, {2.0, 4.0}, {2.0, 0.3}, {2048.0, 1.0}, {nan, 0.1}, {2.0, nan}}) {
    EXPECT_THROW(VoxelMap(PointCloud(), bad), UsageError) << bad.root_size_m << " " << bad.leaf_size_m;
  }
  EXPECT_NO_THROW(VoxelMap(PointCloud(), {1024.0, 1.0}));
}

TEST(VoxelMap, CopiesOutliveTheOriginal) {
  auto original = std::make_unique<VoxelMap>(random_cloud(100, 12), VoxelMapOptions());
  const VoxelMap copy = *original;
  const Eigen::Vector3d first = original->point(0);
  original.reset();
  EXPECT_EQ(copy.point(0), first);
}

TEST(VoxelMap, CostsFewBytesEvenWhereEveryLeafHasOnePoint) {
  PointCloud cloud;
  for (int i = 0; i < 40000; ++i) {
    cloud.positions.push_back({0.0625f * static_cast<float>(i % 200), 0.0625f * static_cast<float>(i / 200), 1.0f});
  }
  const VoxelMap map(cloud, VoxelMapOptions());
  EXPECT_EQ(map.num_nodes(map.leaf_layer()), 40000u);
  EXPECT_LT(static_cast<double>(map.memory_bytes()), 32.0 * 40000);
}

}  // namespace
}  // namespace cpplus
