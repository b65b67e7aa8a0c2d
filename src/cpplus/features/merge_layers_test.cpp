#include "cpplus/features/merge_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "cpplus/core/parallel.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

PlaneSegmentation merged(const VoxelMap& map, PlaneSegmentation planes) {
  merge_layers(map, LeafNeighbors(map), &planes);
  return planes;
}

long count_parallel(const PlaneSegmentation& planes, const Vector3d& normal) {
  return std::count_if(planes.planes.begin(), planes.planes.end(),
                       [&](const MapPlane& p) { return std::abs(p.normal.dot(normal)) > 0.9; });
}

/// A wall of 3 x 2.5 m at y = 0 that is far noisier than the floor before it, as LiDARs see them.
PointCloud floor_and_noisy_wall() {
  Random random(3);
  PointCloud cloud;
  add_surface({0, 0, 0}, {6, 0, 0}, {0, 4, 0}, 3000, 0.006, &random, &cloud);
  add_surface({0, 0, 0}, {3, 0, 0}, {0, 0, 2.5}, 6000, 0.024, &random, &cloud);
  return cloud;
}

TEST(MergeLayers, TheLayersOfANoisyWallBecomeOnePlane) {
  const VoxelMap map(floor_and_noisy_wall(), {});
  const PlaneSegmentation layers = segment_planes(map, {});
  ASSERT_GT(count_parallel(layers, Vector3d::UnitY()), 1);
  const PlaneSegmentation planes = merged(map, layers);
  const auto wall =
      std::max_element(planes.planes.begin(), planes.planes.end(), [](const MapPlane& a, const MapPlane& b) {
        return std::abs(a.normal.y()) * a.num_points < std::abs(b.normal.y()) * b.num_points;
      });
  EXPECT_GT(wall->num_points, 0.93 * 6000 * 3 * 2.5);
  EXPECT_LT(std::abs(wall->signed_distance({1.5, 0.0, 1.25})), 0.001);
  EXPECT_NEAR(wall->sigma_m, 0.024, 0.003);
}

TEST(MergeLayers, TheFacesOfABoardStayApart) {
  Random random(4);
  PointCloud cloud;
  for (const double z : {0.0, 0.045}) add_surface({0, 0, z}, {2, 0, 0}, {0, 2, 0}, 4000, 0.008, &random, &cloud);
  const VoxelMap map(cloud, {});
  const PlaneSegmentation planes = merged(map, segment_planes(map, {}));
  ASSERT_EQ(planes.planes.size(), 2u);
  EXPECT_NEAR(std::abs(planes.planes[0].centroid.z() - planes.planes[1].centroid.z()), 0.045, 0.003);
}

TEST(MergeLayers, NothingToJoinChangesNothing) {
  Random random(5);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 4000, 0.0, &random, &cloud);
  add_surface({0, 0, 1}, {2, 0, 0}, {0, 2, 0}, 4000, 0.0, &random, &cloud);
  const VoxelMap map(cloud, {});
  const PlaneSegmentation before = segment_planes(map, {});
  EXPECT_EQ(merged(map, before).plane_of_point, before.plane_of_point);
}

TEST(MergeLayers, AnEmptyMapHasNoPlanes) {
  const VoxelMap map(PointCloud(), {});
  EXPECT_TRUE(merged(map, segment_planes(map, {})).planes.empty());
}

TEST(MergeLayers, DoesNotDependOnTheNumberOfThreads) {
  const VoxelMap map(floor_and_noisy_wall(), {});
  const PlaneSegmentation layers = segment_planes(map, {});
  set_num_threads(1);
  const PlaneSegmentation one = merged(map, layers);
  set_num_threads(4);
  const PlaneSegmentation four = merged(map, layers);
  set_num_threads(0);
  EXPECT_EQ(one.plane_of_point, four.plane_of_point);
}

}  // namespace
}  // namespace cpplus
