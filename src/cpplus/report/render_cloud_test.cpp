#include "cpplus/report/render_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

// Focal length 100 px, centre of projection at pixel (10, 8); a point at (x, y, z) falls on (10 + 100 x/z, 8 + 100
// y/z).
const Camera kCamera(CameraModel::kPinhole, 21, 17, {100.0, 100.0, 10.0, 8.0});
constexpr Rgb kRed = {200, 0, 0};
constexpr Rgb kGreen = {0, 200, 0};

/// Nothing hides anything.
DepthBuffer no_surface() {
  DepthBuffer buffer;
  buffer.camera = kCamera;
  buffer.cell_px = 1.0;
  buffer.range = RangeImage(kCamera.width(), kCamera.height());
  return buffer;
}

size_t count(const ColorImage& picture, const Rgb& color) {
  return static_cast<size_t>(std::count(picture.pixels.begin(), picture.pixels.end(), color));
}

TEST(RenderCloud, NearPointsAreLargerAndCoverFarOnes) {
  PointCloud cloud;
  cloud.origin = {500000.0, 0.0, 0.0};
  cloud.positions = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 2.0f}, {0.1f, 0.0f, 2.0f}, {0.0f, 0.0f, -1.0f}};
  cloud.colors = {kRed, kGreen, kGreen, kGreen};
  const Rigid3 camera_from_map(Eigen::Quaterniond::Identity(), -cloud.origin);
  // 0.04 m at 1 m: half of 4 px, hence 5x5 pixels; at 2 m: half of 2 px, hence 3x3.
  const ColorImage picture = render_cloud(cloud, no_surface(), camera_from_map, 0.04);
  EXPECT_EQ(picture.at(10, 8), kRed);
  EXPECT_EQ(picture.at(15, 8), kGreen);
  EXPECT_EQ(count(picture, kRed), 25u);
  EXPECT_EQ(count(picture, kGreen), 9u);
}

TEST(RenderCloud, PointsBeyondTheBorderShowTheirPart) {
  PointCloud cloud;
  cloud.positions = {{-0.11f, 0.0f, 1.0f}};  // pixel (-1, 8)
  cloud.colors = {kRed};
  EXPECT_EQ(count(render_cloud(cloud, no_surface(), Rigid3(), 0.04), kRed), 2u * 5u);
}

TEST(RenderCloud, SaysWhereAnImageGaveTheColour) {
  PointCloud cloud;
  cloud.positions = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 2.0f}, {0.1f, 0.0f, 2.0f}};
  cloud.colors = {kRed, kGreen, kGreen};
  cloud.num_views = {0, 3, 3};
  const CloudRendering rendering = render_colored_cloud(cloud, no_surface(), Rigid3(), 0.04);
  EXPECT_EQ(rendering.colored.at(10, 8), 0) << "a point without a colour hides one with";
  EXPECT_EQ(rendering.colored.at(15, 8), 1);
  EXPECT_EQ(std::count(rendering.colored.pixels.begin(), rendering.colored.pixels.end(), 1), 9);
}

TEST(RenderCloud, WhatLiesBehindTheSurfaceDoesNotShineThroughItsGaps) {
  PointCloud cloud;
  cloud.positions = {{-0.05f, 0.0f, 1.0f}, {0.0f, 0.0f, 2.0f}};  // at the second one's pixel no point is in front
  cloud.colors = {kRed, kGreen};
  DepthBuffer surface = no_surface();
  surface.range = RangeImage(kCamera.width(), kCamera.height(), 1.0f);
  const ColorImage picture = render_cloud(cloud, surface, Rigid3(), 0.04);
  EXPECT_EQ(count(picture, kRed), 25u);
  EXPECT_EQ(count(picture, kGreen), 0u);
}

TEST(RenderCloud, APixelMixesThePointsOfOneSurfaceByTheirDistance) {
  PointCloud cloud;
  cloud.positions = {{0.0f, 0.0f, 1.0f}, {0.02f, 0.0f, 1.01f}};  // pixels (10, 8) and (11.98, 8)
  cloud.colors = {kRed, kGreen};
  const ColorImage picture = render_cloud(cloud, no_surface(), Rigid3(), 0.04);
  // Standard deviation 1 px: exp(-0.5 * 1.98^2) = 0.141 of the green point over 1 of the red one.
  EXPECT_NEAR(picture.at(10, 8)[0], 200 / 1.141, 1.0);
  EXPECT_NEAR(picture.at(10, 8)[1], 200 * 0.141 / 1.141, 1.0);
  EXPECT_NEAR(picture.at(11, 8)[0], picture.at(11, 8)[1], 5);
}

TEST(RenderCloud, NeedsColours) {
  PointCloud cloud;
  cloud.positions = {{0.0f, 0.0f, 1.0f}};
  EXPECT_THROW(render_cloud(cloud, no_surface(), Rigid3(), 0.04), Error);
}

TEST(SideBySide, JoinsPicturesOfOneHeight) {
  const ColorImage both = side_by_side(ColorImage(2, 3, kRed), ColorImage(4, 3, kGreen));
  EXPECT_EQ(both.width, 6);
  EXPECT_EQ(count(both, kRed), 6u);
  EXPECT_EQ(count(both, kGreen), 12u);
  EXPECT_EQ(both.at(1, 2), kRed);
  EXPECT_EQ(both.at(2, 2), kGreen);
  EXPECT_THROW(side_by_side(ColorImage(2, 3), ColorImage(2, 4)), Error);
}

}  // namespace
}  // namespace cpplus
