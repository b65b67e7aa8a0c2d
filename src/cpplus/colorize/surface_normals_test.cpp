#include "cpplus/colorize/surface_normals.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

TEST(SurfaceNormals, OfATiltedPlaneArePerpendicularToIt) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, 3).normalized();
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  Random random(1);
  PointCloud cloud;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d x = random.uniform(-1, 1) * u + random.uniform(-1, 1) * v + 0.003 * random.normal() * normal;
    cloud.positions.push_back(x.cast<float>());
  }
  const VoxelMap map(cloud, {});
  const SurfaceNormals normals = estimate_surface_normals(map, 0.25);
  EXPECT_EQ(map.voxel_size(normals.layer), 0.25);
  ASSERT_EQ(normals.of_node.size(), map.num_nodes(normals.layer));
  size_t num_fitted = 0;
  for (uint32_t node = 0; node < normals.of_node.size(); ++node) {
    if (map.num_points(normals.layer, node) < 100) continue;
    const double cosine = std::abs(normals.of_node[node].cast<double>().dot(normal));
    EXPECT_GT(cosine, std::cos(3.0 * M_PI / 180.0));
    ++num_fitted;
  }
  EXPECT_GT(num_fitted, 30u);
}

TEST(SurfaceNormals, AreZeroWhereThePointsFillTheVoxelOrAreTooFew) {
  Random random(2);
  PointCloud cloud;
  for (int i = 0; i < 500; ++i) {
    cloud.positions.push_back(
        Eigen::Vector3d(random.uniform(0, 0.25), random.uniform(0, 0.25), random.uniform(0, 0.25)).cast<float>());
  }
  for (int i = 0; i < 5; ++i) cloud.positions.push_back({1.0f + 0.02f * static_cast<float>(i), 1.0f, 1.0f});
  const SurfaceNormals normals = estimate_surface_normals(VoxelMap(cloud, {}), 0.25);
  ASSERT_EQ(normals.of_node.size(), 2u);
  EXPECT_TRUE(normals.of_node[0].isZero());
  EXPECT_TRUE(normals.of_node[1].isZero());
}

TEST(SurfaceNormals, TakeTheRootsWhereAllVoxelsAreSmaller) {
  PointCloud cloud;
  cloud.positions = {{0.1f, 0.1f, 0.1f}};
  EXPECT_EQ(estimate_surface_normals(VoxelMap(cloud, {}), 100.0).layer, 0);
}

}  // namespace
}  // namespace cpplus
