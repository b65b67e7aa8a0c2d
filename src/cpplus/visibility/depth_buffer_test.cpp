#include "cpplus/visibility/depth_buffer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/error.h"
#include "cpplus/visibility/extended_surfaces.h"
#include "cpplus/visibility/scene_test_util.h"

namespace cpplus {
namespace {

Camera pinhole() { return Camera(CameraModel::kPinhole, 1024, 768, {667, 667, 511.5, 383.5}); }

VoxelMap map_of(const PointCloud& cloud) { return VoxelMap(cloud, VoxelMapOptions()); }

TEST(DepthBuffer, APlaneKeepsItsRangeUnderAnySlope) {
  for (const double slope_deg : {0.0, 45.0, 75.0}) {
    Random random(1);
    PointCloud cloud;
    const double s = std::sin(slope_deg * M_PI / 180.0);
    const double c = std::cos(slope_deg * M_PI / 180.0);
    const Eigen::Vector3d across(0, 12 * c, 12 * s);  // a floor that rises with y
    const Eigen::Vector3d middle(0, 0, 6);
    add_rectangle(middle - 0.5 * across - Eigen::Vector3d(6, 0, 0), {12, 0, 0}, across, 0.02, 0.0, &random, &cloud);
    const DepthBuffer buffer = render_depth_buffer(map_of(cloud), pinhole(), Rigid3(), DepthBufferOptions());
    const Eigen::Vector3d normal(0, -s, c);
    for (double x = 400; x <= 600; x += 50) {
      for (double y = 300; y <= 450; y += 25) {
        const Eigen::Vector3d bearing = *pinhole().unproject({x, y});
        const double range = middle.dot(normal) / bearing.dot(normal);
        // A splat faces the camera: it is wrong by at most the slope over a leaf and a cell.
        const double tolerance = (0.0625 + range * buffer.cell_px / 667) * std::tan(slope_deg * M_PI / 180.0) + 0.04;
        EXPECT_NEAR(buffer.range_at({x, y}), range, tolerance) << slope_deg << " deg, pixel " << x << ' ' << y;
        EXPECT_TRUE(buffer.is_visible(bearing * range, 0.1));
        EXPECT_FALSE(buffer.is_visible(bearing * (range + 2.0 * tolerance + 0.3), 0.1));
      }
    }
  }
}

TEST(DepthBuffer, SilhouettesStayWhereTheyAre) {
  // A board at z = 2 whose right edge projects to x = 511.5, before a wall at z = 6.
  Random random(2);
  PointCloud cloud;
  add_rectangle({-3, -3, 2}, {3, 0, 0}, {0, 6, 0}, 0.01, 0.0, &random, &cloud);
  add_rectangle({-8, -8, 6}, {16, 0, 0}, {0, 16, 0}, 0.02, 0.0, &random, &cloud);
  const DepthBuffer buffer = render_depth_buffer(map_of(cloud), pinhole(), Rigid3(), DepthBufferOptions());
  const double leaf_px = 667 * 0.0625 / 2;
  for (double y = 200; y < 600; y += 37) {
    EXPECT_NEAR(buffer.range_at({511.5 - leaf_px, y}), 2.0, 0.3) << y;
    EXPECT_GT(buffer.range_at({511.5 + 0.6 * leaf_px, y}), 5.9) << y;
  }
}

TEST(DepthBuffer, RangesAreAlongTheRayInEveryModel) {
  // A ball of 3 m around the camera: the same range everywhere, whatever the lens.
  Random random(5);
  PointCloud cloud;
  for (int i = 0; i < 400000; ++i) {
    const Eigen::Vector3d x = 3.0 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    cloud.positions.push_back(x.cast<float>());
  }
  const VoxelMap map = map_of(cloud);
  const Rigid3 turned(so3_exp({0.3, -0.5, 1.0}), Eigen::Vector3d::Zero());
  const std::vector<Camera> cameras = {
      Camera(CameraModel::kOpenCv, 640, 480, {400, 400, 320, 240, -0.1, 0.03, 0.001, -0.0005}),
      Camera(CameraModel::kOpenCvFisheye, 640, 640, {203, 203, 319.5, 319.5, 0, 0, 0, 0}),
      Camera(CameraModel::kEquirectangular, 1024, 512, {1024, 512})};
  for (const Camera& camera : cameras) {
    const DepthBuffer buffer = render_depth_buffer(map, camera, turned, DepthBufferOptions());
    // The poles of a panorama are left out: the magnification is without bound there.
    const double first_y = camera.model() == CameraModel::kEquirectangular ? 40.0 : 0.0;
    for (double x = 0; x < camera.width() - 1; x += camera.width() / 13.0) {
      for (double y = first_y; y < camera.height() - 1 - first_y; y += camera.height() / 11.0) {
        if (!camera.unproject({x, y})) continue;
        EXPECT_NEAR(buffer.range_at({x, y}), 3.0, 0.05) << camera_model_name(camera.model()) << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(DepthBuffer, TheSeamOfAPanoramaIsClosed) {
  PointCloud cloud;  // one leaf straight behind the camera, whose square lies on both sides of the seam
  cloud.positions.push_back({0.03f, 0.03f, -2.0f});
  const Camera camera(CameraModel::kEquirectangular, 2048, 1024, {2048, 1024});
  const DepthBuffer buffer = render_depth_buffer(map_of(cloud), camera, Rigid3(), DepthBufferOptions());
  EXPECT_EQ(buffer.column(-1), buffer.range.width - 1);
  std::vector<ProjectedLeaf> leaves = {{0, 2.0f, {0.0f, 512.0f}, true}};
  for (int x = -9; x <= 9; ++x)
    for (int y = -9; y <= 9; ++y)  // a dense patch around the seam
      leaves.push_back(
          {0, 2.0f, {static_cast<float>((2048 + 3 * x) % 2048), 512.0f + 3.0f * static_cast<float>(y)}, true});
  const DepthBuffer patch = render_depth_buffer(leaves, 0.0625, camera, DepthBufferOptions());
  for (const double x : {2030.0, 2047.0, 0.0, 18.0}) EXPECT_EQ(patch.range_at({x, 512}), 2.0f) << x;
  EXPECT_EQ(patch.range_at({100, 512}), 0.0f);
}

TEST(DepthBuffer, FarFromTheOriginNothingChanges) {
  Random random(6);
  PointCloud near_cloud;
  add_rectangle({-4, -4, 5}, {8, 0, 0}, {0, 8, 0}, 0.02, 0.01, &random, &near_cloud);
  PointCloud utm_cloud = near_cloud;
  utm_cloud.origin = {500000, 5800000, 100};
  const Rigid3 camera_from_utm(Eigen::Quaterniond::Identity(), -utm_cloud.origin);
  const DepthBuffer a = render_depth_buffer(map_of(near_cloud), pinhole(), Rigid3(), DepthBufferOptions());
  const DepthBuffer b = render_depth_buffer(map_of(utm_cloud), pinhole(), camera_from_utm, DepthBufferOptions());
  ASSERT_EQ(a.range.pixels.size(), b.range.pixels.size());
  for (size_t i = 0; i < a.range.pixels.size(); ++i) ASSERT_NEAR(a.range.pixels[i], b.range.pixels[i], 1e-4);
}

TEST(ExtendedSurfaces, AWallIsOneAndABodyIsNot) {
  Random random(8);
  PointCloud cloud;
  add_rectangle({-3, -3, 6}, {6, 0, 0}, {0, 6, 0}, 0.03, 0.01, &random, &cloud);  // wall
  const size_t num_wall = cloud.size();
  add_rectangle({0, -0.85, 3}, {0.4, 0, 0}, {0, 1.7, 0}, 0.03, 0.01, &random, &cloud);  // a person's front
  const VoxelMap map = map_of(cloud);
  DepthBufferOptions options;
  options.min_occluder_extent = 0.8;
  const std::vector<uint32_t> roots = select_roots(map, pinhole(), Rigid3(), 20.0, 0.0);
  const std::vector<ProjectedLeaf> leaves = project_leaves(map, roots, pinhole(), Rigid3(), options);
  size_t wall = 0;
  size_t hiding_wall = 0;
  for (const ProjectedLeaf& leaf : leaves) {
    const bool is_wall = map.input_index(map.points_begin(map.leaf_layer(), leaf.leaf)) < num_wall;
    wall += is_wall;
    hiding_wall += is_wall && leaf.hides;
    EXPECT_TRUE(is_wall || !leaf.hides);
  }
  EXPECT_GT(static_cast<double>(hiding_wall), 0.97 * static_cast<double>(wall));  // all but a rim
  const DepthBuffer buffer = render_depth_buffer(map, pinhole(), Rigid3(), options);
  EXPECT_TRUE(buffer.is_visible({0.4, 0, 6}, 0.1));  // behind the person
  options.min_occluder_extent = 0.0;
  EXPECT_FALSE(render_depth_buffer(map, pinhole(), Rigid3(), options).is_visible({0.4, 0, 6}, 0.1));
}

TEST(DepthBuffer, AnEmptyMapHidesNothing) {
  const DepthBuffer buffer = render_depth_buffer(VoxelMap(PointCloud(), VoxelMapOptions()), pinhole(), Rigid3(), {});
  EXPECT_TRUE(buffer.is_visible({0, 0, 10}, 0.0));
  EXPECT_FALSE(buffer.is_visible({0, 0, -10}, 0.0));  // behind the camera
  EXPECT_FALSE(buffer.is_visible({50, 0, 10}, 0.0));  // outside the image
}

TEST(DepthBuffer, RefusesBadOptions) {
  DepthBufferOptions options;
  options.cell_leaves = 0.0;
  EXPECT_THROW(render_depth_buffer(VoxelMap(), pinhole(), Rigid3(), options), Error);
}

}  // namespace
}  // namespace cpplus
