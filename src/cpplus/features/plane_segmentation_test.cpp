#include "cpplus/features/plane_segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// Planes with at least this many points, largest first.
std::vector<MapPlane> large_planes(const PlaneSegmentation& planes, uint32_t min_points) {
  std::vector<MapPlane> large;
  std::copy_if(planes.planes.begin(), planes.planes.end(), std::back_inserter(large),
               [&](const MapPlane& p) { return p.num_points >= min_points; });
  std::sort(large.begin(), large.end(),
            [](const MapPlane& a, const MapPlane& b) { return a.num_points > b.num_points; });
  return large;
}

TEST(PlaneSegmentation, OneExactPlaneIsFoundExactly) {
  Random random(1);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 1.5, 0}, 2000, 0.0, &random, &cloud);
  transform(oblique_frame(), &cloud);
  const VoxelMap map(cloud, {});
  const PlaneSegmentation planes = segment_planes(map, {});
  ASSERT_EQ(planes.planes.size(), 1u);
  const Vector3d normal = oblique_frame().linear().col(2);
  EXPECT_EQ(planes.planes[0].num_points, cloud.size());
  EXPECT_NEAR(std::abs(planes.planes[0].normal.dot(normal)), 1.0, 1e-9);
  EXPECT_NEAR(planes.planes[0].signed_distance(oblique_frame().translation()), 0.0, 1e-5);
  EXPECT_NEAR(planes.planes[0].sigma_m, 0.0, 1e-5);
}

TEST(PlaneSegmentation, NoiseIsMeasuredAndHardlyTiltsAPlane) {
  Random random(2);
  PointCloud cloud;
  add_surface({0, 0, 0}, {3, 0, 0}, {0, 2, 0}, 2000, 0.02, &random, &cloud);
  transform(oblique_frame(), &cloud);
  const PlaneSegmentation planes = segment_planes(VoxelMap(cloud, {}), {});
  const auto large = large_planes(planes, 1000);
  ASSERT_EQ(large.size(), 1u);
  EXPECT_GT(large[0].num_points, 0.97 * static_cast<double>(cloud.size()));
  // sigma / (sqrt(n) * spread) = 0.02 / (110 * 0.58) rad = 0.02 deg.
  EXPECT_GT(std::abs(large[0].normal.dot(oblique_frame().linear().col(2))), std::cos(0.08 * M_PI / 180));
  EXPECT_NEAR(large[0].signed_distance(oblique_frame().translation()), 0.0, 0.002);
  EXPECT_NEAR(planes.noise_m, 0.02, 0.005);
}

TEST(PlaneSegmentation, BothFacesOfAThinWallAreDistinct) {
  Random random(3);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 2000, 0.005, &random, &cloud);
  add_surface({0, 0, 0.1}, {2, 0, 0}, {0, 2, 0}, 2000, 0.005, &random, &cloud);
  transform(oblique_frame(), &cloud);
  const VoxelMap map(cloud, {});
  const PlaneSegmentation planes = segment_planes(map, {});
  const auto large = large_planes(planes, 4000);
  ASSERT_EQ(large.size(), 2u);
  EXPECT_GT(std::abs(large[0].normal.dot(large[1].normal)), std::cos(0.1 * M_PI / 180));
  EXPECT_NEAR(std::abs(large[0].signed_distance(large[1].centroid)), 0.1, 0.002);
}

TEST(PlaneSegmentation, PointsAndLeavesAgree) {
  Random random(4);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 1000, 0.01, &random, &cloud);
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 0, 2}, 1000, 0.01, &random, &cloud);
  const VoxelMap map(cloud, {});
  const PlaneSegmentation planes = segment_planes(map, {});
  ASSERT_EQ(planes.plane_of_point.size(), map.num_points());
  ASSERT_EQ(planes.leaves.size(), planes.planes.size());
  size_t assigned = 0;
  for (size_t p = 0; p < planes.planes.size(); ++p) {
    uint32_t points = 0;
    EXPECT_TRUE(std::is_sorted(planes.leaves[p].begin(), planes.leaves[p].end()));
    for (const uint32_t leaf : planes.leaves[p]) {
      for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
        points += planes.plane_of_point[i] == static_cast<int32_t>(p);
      }
    }
    EXPECT_EQ(points, planes.planes[p].num_points);
    assigned += points;
  }
  EXPECT_EQ(assigned, static_cast<size_t>(std::count_if(planes.plane_of_point.begin(), planes.plane_of_point.end(),
                                                        [](int32_t p) { return p >= 0; })));
}

TEST(PlaneSegmentation, ACloudOfChaosHasNoPlane) {
  Random random(5);
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i) {
    cloud.positions.emplace_back(random.uniform(0, 2), random.uniform(0, 2), random.uniform(0, 2));
  }
  const PlaneSegmentation planes = segment_planes(VoxelMap(cloud, {}), {});
  EXPECT_EQ(large_planes(planes, 200).size(), 0u);
}

TEST(PlaneSegmentation, EmptyMapHasNone) { EXPECT_TRUE(segment_planes(VoxelMap(PointCloud{}, {}), {}).planes.empty()); }

TEST(PlaneSegmentation, PointsThatAreNotNumbersChangeNothing) {
  Random random(6);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 1000, 0.01, &random, &cloud);
  const PlaneSegmentation clean = segment_planes(VoxelMap(cloud, {}), {});
  cloud.positions.insert(cloud.positions.begin() + 100, {std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f});
  cloud.positions.insert(cloud.positions.begin() + 300, {0.0f, std::numeric_limits<float>::infinity(), 0.0f});
  cloud.intensities.clear();
  const PlaneSegmentation dirty = segment_planes(VoxelMap(cloud, {}), {});
  ASSERT_EQ(dirty.planes.size(), clean.planes.size());
  for (size_t p = 0; p < clean.planes.size(); ++p) {
    EXPECT_EQ(dirty.planes[p].normal, clean.planes[p].normal);
    EXPECT_EQ(dirty.planes[p].num_points, clean.planes[p].num_points);
  }
}

TEST(PlaneSegmentation, RejectsOptionsOutOfRange) {
  const VoxelMap map(PointCloud{}, {});
  const auto rejects = [&](auto change) {
    PlaneSegmentationOptions options;
    change(options);
    EXPECT_THROW(segment_planes(map, options), Error);
  };
  rejects([](auto& o) { o.max_eigenvalue_ratio = 0.0; });
  rejects([](auto& o) { o.max_eigenvalue_ratio = 1.0; });
  rejects([](auto& o) { o.max_thickness_m = 0.0; });
  rejects([](auto& o) { o.min_seed_points = 3; });
  rejects([](auto& o) { o.min_plane_points = 3; });
  rejects([](auto& o) { o.max_distance_sigmas = std::nan(""); });
  rejects([](auto& o) { o.max_angle_deg = 90.0; });
}

}  // namespace
}  // namespace cpplus
