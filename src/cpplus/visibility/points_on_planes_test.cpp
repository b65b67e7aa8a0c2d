#include "cpplus/visibility/points_on_planes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "cpplus/core/random.h"
#include "cpplus/visibility/point_spacing.h"

namespace cpplus {
namespace {

/// A wall at z = 4 m, and before it points of somebody who walked by.
PointCloud wall_and_walker() {
  Random random(2);
  PointCloud cloud;
  for (int k = 0; k < 20000; ++k) {
    const double depth = 4.0 + 0.01 * random.normal();
    cloud.positions.push_back(Eigen::Vector3d(random.uniform(-2, 2), random.uniform(-2, 2), depth).cast<float>());
  }
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector3d x(random.uniform(-0.3, 0.3), random.uniform(-0.9, 0.9), random.uniform(2.0, 2.3));
    cloud.positions.push_back(x.cast<float>());
  }
  return cloud;
}

PlaneBuffer view_of_wall(const std::vector<MapPlane>& planes) {
  PlaneBuffer view;
  view.camera = Camera(CameraModel::kPinhole, 400, 300, {300, 300, 200, 150});
  view.cell_px = 4.0;
  view.plane = Image<int32_t>(100, 75, 0);
  view.planes = &planes;
  return view;
}

TEST(PointsOnSeenPlanes, AreThoseOfTheWallAlsoBehindWhoWalkedBefore) {
  const VoxelMap map(wall_and_walker(), {});
  std::vector<MapPlane> planes(1);
  planes[0].centroid = {0, 0, 4};
  const PlaneBuffer view = view_of_wall(planes);
  const std::vector<PointInView> seen = points_on_seen_planes(map, leaf_point_spacing(map), view, 10.0, 0.05);
  ASSERT_GT(seen.size(), 5000u);
  uint32_t behind = 0;
  for (const PointInView& point : seen) {
    EXPECT_NEAR(map.point(point.index).z(), 4.0, 0.05);
    const auto pixel = view.camera.project(map.point(point.index));
    ASSERT_TRUE(pixel);
    EXPECT_LT((point.pixel.cast<double>() - *pixel).norm(), 1e-2);
    behind += map.point(point.index).head<2>().cwiseAbs().maxCoeff() < 0.4;
  }
  EXPECT_GT(behind, 500u);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.index < b.index; }));
}

TEST(PointsOnSeenPlanes, NoneWhereAnotherPlaneIsBeforeThemOrNone) {
  const VoxelMap map(wall_and_walker(), {});
  std::vector<MapPlane> planes(2);
  planes[0].centroid = {0, 0, 4};
  planes[1].centroid = {0, 0, 3};
  PlaneBuffer view = view_of_wall(planes);
  for (int y = 0; y < view.plane.height; ++y) {
    for (int x = 0; x < view.plane.width; ++x) view.plane.at(x, y) = x < 30 ? 1 : x < 60 ? PlaneBuffer::kNone : 0;
  }
  const std::vector<PointInView> seen = points_on_seen_planes(map, leaf_point_spacing(map), view, 10.0, 0.05);
  EXPECT_FALSE(seen.empty());
  for (const PointInView& point : seen) EXPECT_GT(point.pixel.x(), 239.0f);
  EXPECT_TRUE(points_on_seen_planes(VoxelMap(), {}, view, 10.0, 0.05).empty());
}

}  // namespace
}  // namespace cpplus
