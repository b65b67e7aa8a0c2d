#include "cpplus/report/overlay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

const Camera kPinhole(CameraModel::kPinhole, 201, 101, {100.0, 100.0, 100.0, 50.0});
const Rgb kWhite{255, 255, 255};

size_t num_lit(const ColorImage& image) {
  return static_cast<size_t>(
      std::count_if(image.pixels.begin(), image.pixels.end(), [](const Rgb& p) { return p[0] > 100; }));
}

TEST(DrawSegments, GoThroughTheProjectionsOfTheirPoints) {
  ColorImage image(201, 101);
  // From (100 - 50, 50) to (100 + 50, 50).
  draw_segments({{{-1, 0, 2}, {1, 0, 2}}}, kPinhole, {}, kWhite, &image);
  for (int x = 52; x <= 148; ++x) EXPECT_GT(image.at(x, 50)[0], 200) << x;
  EXPECT_EQ(image.at(45, 50), Rgb{});
  EXPECT_EQ(image.at(155, 50), Rgb{});
  EXPECT_EQ(image.at(100, 47), Rgb{});
}

TEST(DrawSegments, BendWithTheDistortion) {
  // With strong barrel distortion a line 0.8 above the axis at depth 2 is drawn where the camera sees it, which is
  // nearer to the centre at its ends than a straight line through its middle.
  const Camera camera(CameraModel::kSimpleRadial, 201, 101, {100.0, 100.0, 50.0, -0.2});
  ColorImage image(201, 101);
  draw_segments({{{-1.4, -0.8, 2}, {1.4, -0.8, 2}}}, camera, {}, kWhite, &image);
  const auto middle = camera.project({0, -0.8, 2});
  const auto end = camera.project({1.3, -0.8, 2});
  ASSERT_TRUE(middle && end);
  ASSERT_GT(end->y(), middle->y() + 2.0);
  const auto pixel = [](double v) { return static_cast<int>(std::lround(v)); };
  EXPECT_GT(image.at(pixel(middle->x()), pixel(middle->y()))[0], 100);
  EXPECT_GT(image.at(pixel(end->x()), pixel(end->y()))[0], 100);
  EXPECT_EQ(image.at(pixel(end->x()), pixel(middle->y())), Rgb{});
}

TEST(DrawSegments, OnlyThePartInFrontOfTheCameraIsDrawn) {
  ColorImage image(201, 101);
  draw_segments({{{0, 0.1, -5}, {0, 0.1, 5}}}, kPinhole, {}, kWhite, &image);
  EXPECT_GT(image.at(100, 60)[0], 100);  // at 1 m
  EXPECT_EQ(image.at(100, 40), Rgb{});   // nothing mirrored from behind
  ColorImage behind(201, 101);
  draw_segments({{{-1, 0, -2}, {1, 0, -2}}}, kPinhole, {}, kWhite, &behind);
  EXPECT_EQ(num_lit(behind), 0u);
}

TEST(DrawSegments, OfAPanoramaDoNotCrossTheSeamTheWrongWay) {
  const Camera panorama(CameraModel::kEquirectangular, 400, 200, {400.0, 200.0});
  ColorImage image(400, 200);
  draw_segments({{{-1, 0, -3}, {1, 0, -3}}}, panorama, {}, kWhite, &image);  // straight behind: at both borders
  EXPECT_GT(num_lit(image), 10u);
  for (int x = 60; x < 340; ++x) EXPECT_EQ(image.at(x, 100), Rgb{}) << x;
}

TEST(OverlayBackground, IsDarkGrey) {
  ColorImage image(1, 1, Rgb{100, 200, 50});
  EXPECT_EQ(overlay_background(image).at(0, 0), (Rgb{92, 92, 92}));  // 0.6 * (29.9 + 117.4 + 5.7)
}

TEST(BeforeAfterOverlay, ShowsTheOldPoseInRedOnTheLeftAndTheNewInGreenOnTheRight) {
  const ColorImage image(201, 101, Rgb{0, 0, 0});
  const Rigid3 before{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0.4, 0)};  // 20 px lower at 2 m
  const ColorImage result = before_after_overlay(image, {{{-1, 0, 2}, {1, 0, 2}}}, kPinhole, before, {});
  ASSERT_EQ(result.width, 402);
  EXPECT_GT(result.at(100, 70)[0], 200);  // red, a little softened by anti-aliasing
  EXPECT_LT(result.at(100, 70)[1], 80);
  EXPECT_EQ(result.at(100, 50), Rgb{});
  EXPECT_GT(result.at(201 + 100, 50)[1], 200);
  EXPECT_LT(result.at(201 + 100, 50)[0], 80);
  EXPECT_EQ(result.at(201 + 100, 70), Rgb{});
}

}  // namespace
}  // namespace cpplus
