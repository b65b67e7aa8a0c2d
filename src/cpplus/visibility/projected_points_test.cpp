#include "cpplus/visibility/projected_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/core/random.h"
#include "cpplus/visibility/nodes_in_view.h"
#include "cpplus/visibility/point_spacing.h"

namespace cpplus {
namespace {

const Rigid3 kCameraFromMap(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
                            Eigen::Vector3d(0.3, -0.2, 0.5));

PlaneBuffer open_view(const Camera& camera) {
  PlaneBuffer view;
  view.camera = camera;
  view.camera_from_map = kCameraFromMap;
  return view;
}

Camera opencv() { return Camera(CameraModel::kOpenCv, 640, 480, {400, 402, 320, 240, -0.1, 0.03, 7e-4, -5e-4}); }
Camera fisheye() { return Camera(CameraModel::kOpenCvFisheye, 800, 800, {300, 300, 400, 400, 0.01, 0, 0, 0}); }

// In clusters, so that nodes have several points and some places none.
VoxelMap clusters() {
  Random random(5);
  PointCloud cloud;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d middle(random.uniform(-8, 8), random.uniform(-8, 8), random.uniform(-8, 8));
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d offset(random.normal(), random.normal(), random.normal());
      cloud.positions.push_back((middle + 0.1 * offset).cast<float>());
    }
  }
  return VoxelMap(cloud, {});
}

struct PointsInImage {
  std::vector<ProjectedPoint> points;
  std::vector<uint32_t> indices;
};

PointsInImage points_in(const VoxelMap& map, const std::vector<float>& spacing, const Camera& camera) {
  PointsInImage all;
  project_points(map, spacing, open_view(camera), 6.0,
                 [&](std::span<const ProjectedPoint> points, std::span<const uint32_t> indices) {
                   all.points.insert(all.points.end(), points.begin(), points.end());
                   all.indices.insert(all.indices.end(), indices.begin(), indices.end());
                 });
  return all;
}

TEST(ProjectPoints, AreThoseOfOneByOneInTheOrderOfTheMap) {
  const VoxelMap map = clusters();
  const std::vector<float> spacing = leaf_point_spacing(map);
  for (const Camera& camera : {opencv(), fisheye()}) {
    const auto [points, indices] = points_in(map, spacing, camera);
    auto point = points.begin();
    ASSERT_EQ(indices.size(), points.size());
    for (uint32_t leaf = 0; leaf < map.num_nodes(map.leaf_layer()); ++leaf) {
      for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
        const Eigen::Vector3d x = kCameraFromMap * map.point(i);
        const auto pixel = camera.project(x);
        if (!std::isfinite(spacing[leaf]) || x.norm() > 6.0 || !pixel || !camera.in_image(*pixel, -0.5)) continue;
        ASSERT_NE(point, points.end());
        EXPECT_EQ(indices[static_cast<size_t>(point - points.begin())], i);
        EXPECT_NEAR(point->pixel.x(), pixel->x(), 1e-3);
        EXPECT_NEAR(point->pixel.y(), pixel->y(), 1e-3);
        EXPECT_NEAR(point->range, x.norm(), 1e-5);
        EXPECT_NEAR(point->spacing_px, spacing[leaf] / x.norm() * camera.pixels_per_radian(), 1e-3);
        ++point;
      }
    }
    EXPECT_EQ(point, points.end());
    EXPECT_GT(points.size(), 100u);
  }
}

TEST(ProjectPoints, AnEmptyMapHasNone) { EXPECT_TRUE(points_in(VoxelMap(), {}, opencv()).points.empty()); }

TEST(NodesInView, HoldAllPointsInTheImageAndFewOthers) {
  const VoxelMap map = clusters();
  for (const Camera& camera : {opencv(), fisheye()}) {
    for (const int layer : {0, 3, map.leaf_layer()}) {
      const std::vector<uint32_t> nodes = nodes_in_view(map, layer, camera, kCameraFromMap, 6.0, 0.0, HiddenRanges());
      EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end()));
      for (uint32_t node = 0; node < map.num_nodes(layer); ++node) {
        bool in_image = false;
        for (uint32_t i = map.points_begin(layer, node); i < map.points_end(layer, node); ++i) {
          const Eigen::Vector3d x = kCameraFromMap * map.point(i);
          const auto pixel = camera.project(x);
          in_image |= x.norm() < 6.0 && pixel && camera.in_image(*pixel, -0.5);
        }
        EXPECT_TRUE(!in_image || std::binary_search(nodes.begin(), nodes.end(), node)) << layer << " " << node;
      }
    }
  }
  const size_t leaves = nodes_in_view(map, map.leaf_layer(), opencv(), kCameraFromMap, 6.0, 0.0, {}).size();
  EXPECT_LT(leaves, map.num_nodes(map.leaf_layer()) / 5);
}

TEST(NodesInView, AMarginTakesMoreAndHiddenRangesFewer) {
  const VoxelMap map = clusters();
  const auto count = [&](double margin_m, const HiddenRanges& hidden) {
    return nodes_in_view(map, map.leaf_layer(), opencv(), kCameraFromMap, 6.0, margin_m, hidden).size();
  };
  PlaneBuffer wall = open_view(opencv());
  wall.range_bound = RangeImage(160, 120, 3.0f);
  EXPECT_GT(count(0.5, {}), count(0.0, {}));
  EXPECT_LT(count(0.0, HiddenRanges(wall)), count(0.0, {}));
  EXPECT_GT(count(0.0, HiddenRanges(wall)), 0u);
}

TEST(NodesInView, AnEmptyMapHasNone) {
  EXPECT_TRUE(nodes_in_view(VoxelMap(), 0, opencv(), kCameraFromMap, 6.0, 0.0, {}).empty());
}

}  // namespace
}  // namespace cpplus
