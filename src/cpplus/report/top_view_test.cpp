#include "cpplus/report/top_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>

namespace cpplus {
namespace {

// Looks along +x of a map whose z is up: camera z = map x, camera y = map -z.
Rigid3 level_camera() {
  Eigen::Matrix3d camera_from_map;
  camera_from_map << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {camera_from_map, Eigen::Vector3d::Zero()};
}

TEST(TopView, UpIsTheAxisThatCamerasHoldUpwards) {
  EXPECT_EQ(up_axis({}), Eigen::Vector3d::UnitZ());
  EXPECT_EQ(up_axis({level_camera()}), Eigen::Vector3d::UnitZ());
  EXPECT_EQ(up_axis({Rigid3()}), Eigen::Vector3d(0, -1, 0));  // a map in camera axes, y down
}

TEST(TopView, AxesAreRightHanded) {
  for (const Eigen::Vector3d& up : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(1, 0, 0)}) {
    const TopView view(up);
    EXPECT_NEAR((view.right.cross(view.ahead) - up).norm(), 0.0, 1e-12);
  }
  EXPECT_EQ(TopView(Eigen::Vector3d::UnitZ()) * Eigen::Vector3d(2, 3, 4), Eigen::Vector2d(2, 3));
}

TEST(TopView, BoundsHaveTheMarginOrHalfTheExtent) {
  const TopViewBounds wide = bounds_around({{0, 0}, {40, 10}}, 5.0);
  EXPECT_EQ(wide.min, Eigen::Vector2d(-20, -20));
  EXPECT_EQ(wide.max, Eigen::Vector2d(60, 30));
  EXPECT_EQ(bounds_around({{1, 1}}, 5.0).max, Eigen::Vector2d(6, 6));
}

// From the origin to `max`, metres; roots of 4 m, leaves of 1 m.
cv::Mat floor_plan(const PointCloud& cloud, const Eigen::Vector2d& max) {
  VoxelMapOptions options;
  options.root_size_m = 4.0;
  options.leaf_size_m = 1.0;
  TopViewBounds bounds;
  bounds.max = max;
  const std::vector<uint8_t> png =
      floor_plan_png(VoxelMap(cloud, options), TopView(Eigen::Vector3d::UnitZ()), bounds, 1000);
  return cv::imdecode(png, cv::IMREAD_UNCHANGED);
}

TEST(TopView, FloorPlanShowsLeavesOfRootsThatReachBeyondIt) {
  PointCloud cloud;  // in a root from 4 to 8 m, one leaf in the picture and one beyond it; another root far from it
  for (const float x : {4.5f, 7.5f, 50.5f}) cloud.positions.emplace_back(x, 0.5f, 0.5f);
  const cv::Mat picture = floor_plan(cloud, {5, 1});
  ASSERT_EQ(picture.cols, 5);
  for (int column = 0; column < 5; ++column) {
    EXPECT_EQ(picture.at<cv::Vec4b>(0, column)[3] > 0, column == 4) << column;
  }
}

TEST(TopView, FloorPlanShowsColumnsOfLeavesWhereTheyStand) {
  PointCloud cloud;  // a column of 8 leaves at (3.5, 0.5), one leaf at (0.5, 1.5)
  for (int i = 0; i < 8; ++i) cloud.positions.emplace_back(3.5f, 0.5f, 0.5f + static_cast<float>(i));
  cloud.positions.emplace_back(0.5f, 1.5f, 0.5f);
  const cv::Mat picture = floor_plan(cloud, {4, 2});
  ASSERT_EQ(picture.cols, 4);  // pixels are no smaller than leaves
  ASSERT_EQ(picture.rows, 2);
  ASSERT_EQ(picture.channels(), 4);
  const auto opacity = [&](int row, int column) { return picture.at<cv::Vec4b>(row, column)[3]; };
  EXPECT_EQ(opacity(1, 3), 128);  // 1 - 2^-1, the lower row is y in [0, 1]
  EXPECT_NEAR(opacity(0, 0), 255 * (1 - std::exp2(-1.0 / 8)), 1.0);
  EXPECT_EQ(opacity(0, 3), 0);
}

}  // namespace
}  // namespace cpplus
