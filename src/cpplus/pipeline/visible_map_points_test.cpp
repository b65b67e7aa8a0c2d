#include "cpplus/pipeline/visible_map_points.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

/// A square of points, 2 cm apart, in a plane z = const around the axis.
void add_square(double half_m, double z_m, PointCloud* cloud) {
  for (double x = -half_m; x <= half_m; x += 0.02) {
    for (double y = -half_m; y <= half_m; y += 0.02)
      cloud->positions.push_back(Eigen::Vector3d(x, y, z_m).cast<float>());
  }
}

TEST(VisibleMapPoints, LieOnTheNearestSurfaceAndCoverTheImageEvenly) {
  PointCloud cloud;
  add_square(3.0, 5.03, &cloud);  // fills the image
  add_square(0.5, 2.53, &cloud);  // hides its middle: 400 * 0.5 / 2.53 = 79 px either side of the centre
  const Camera camera(CameraModel::kPinhole, 320, 240, {400.0, 400.0, 159.5, 119.5});
  const auto points = visible_map_points(VoxelMap(cloud, {}), camera, {});
  size_t num_near = 0;
  for (const Eigen::Vector3d& point : points) {
    const bool near = std::abs(point.z() - 2.53) < 0.05;
    EXPECT_TRUE(near || std::abs(point.z() - 5.03) < 0.1) << point.transpose();
    num_near += near ? 1 : 0;
  }
  // One point for 8 x 8 pixels: 1200 in all, and (158 / 8)^2 = 390 on the near square.
  EXPECT_NEAR(static_cast<double>(points.size()), 1200.0, 60.0);
  EXPECT_NEAR(static_cast<double>(num_near), 390.0, 40.0);
}

TEST(VisibleMapPoints, AreNoneWhereTheMapIsBehindTheCamera) {
  PointCloud cloud;
  add_square(1.0, -5.0, &cloud);
  const Camera camera(CameraModel::kPinhole, 320, 240, {400.0, 400.0, 159.5, 119.5});
  EXPECT_TRUE(visible_map_points(VoxelMap(cloud, {}), camera, {}).empty());
}

}  // namespace
}  // namespace cpplus
