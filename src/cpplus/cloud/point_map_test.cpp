#include "cpplus/cloud/point_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using ::testing::ElementsAre;

/// Three points in three roots, the last first.
PointCloud three_points() {
  PointCloud cloud;
  cloud.origin = {10.0, 0.0, 0.0};
  cloud.positions = {{5.0f, 0.5f, 0.5f}, {1.0f, 0.5f, 0.5f}, {3.0f, 0.5f, 0.5f}};
  cloud.intensities = {50.0f, 10.0f, 30.0f};
  cloud.colors = {{5, 5, 5}, {1, 1, 1}, {3, 3, 3}};
  cloud.stamps_s = {0.5, 0.1, 0.3};
  cloud.num_views = {5, 1, 3};
  cloud.best_images = {500, 100, 300};
  cloud.color_spreads = {55, 11, 33};
  cloud.las_frame = LasFrame();
  return cloud;
}

TEST(PointMap, AttributesAreInTheOrderOfTheMap) {
  const PointMap points = make_point_map(three_points(), {});
  EXPECT_THAT(points.map.positions(), ElementsAre(Eigen::Vector3f(1.0f, 0.5f, 0.5f), Eigen::Vector3f(3.0f, 0.5f, 0.5f),
                                                  Eigen::Vector3f(5.0f, 0.5f, 0.5f)));
  EXPECT_THAT(points.intensities, ElementsAre(10.0f, 30.0f, 50.0f));
  EXPECT_THAT(points.colors, ElementsAre(Rgb{1, 1, 1}, Rgb{3, 3, 3}, Rgb{5, 5, 5}));
  EXPECT_THAT(points.stamps_s, ElementsAre(0.1, 0.3, 0.5));
  EXPECT_THAT(points.num_views, ElementsAre(1, 3, 5));
  EXPECT_THAT(points.best_images, ElementsAre(100u, 300u, 500u));
  EXPECT_THAT(points.color_spreads, ElementsAre(11, 33, 55));
}

TEST(PointMap, TheCloudComesBackInItsOrder) {
  const PointCloud cloud = three_points();
  const PointCloud back = cloud_in_input_order(make_point_map(cloud, {}));
  EXPECT_EQ(back.origin, cloud.origin);
  EXPECT_EQ(back.positions, cloud.positions);
  EXPECT_EQ(back.intensities, cloud.intensities);
  EXPECT_EQ(back.colors, cloud.colors);
  EXPECT_EQ(back.stamps_s, cloud.stamps_s);
  EXPECT_EQ(back.num_views, cloud.num_views);
  EXPECT_EQ(back.best_images, cloud.best_images);
  EXPECT_EQ(back.color_spreads, cloud.color_spreads);
  EXPECT_TRUE(back.las_frame.has_value());
}

TEST(PointMap, WhatTheCloudDoesNotHaveStaysEmpty) {
  PointCloud cloud;
  cloud.positions = {{1.0f, 2.0f, 3.0f}};
  const PointMap points = make_point_map(cloud, {});
  EXPECT_TRUE(points.intensities.empty());
  EXPECT_TRUE(points.colors.empty());
  EXPECT_TRUE(cloud_in_input_order(points).stamps_s.empty());
}

TEST(PointMap, APointThatTheMapLeftOutHasNoPlaceToComeBackTo) {
  PointCloud cloud = three_points();
  cloud.positions[0].x() = std::numeric_limits<float>::quiet_NaN();
  const PointMap points = make_point_map(cloud, {});
  EXPECT_THAT(points.intensities, ElementsAre(10.0f, 30.0f));
  EXPECT_THROW(cloud_in_input_order(points), Error);
}

}  // namespace
}  // namespace cpplus
