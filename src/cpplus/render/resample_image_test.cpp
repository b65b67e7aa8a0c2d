#include "cpplus/render/resample_image.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

/// Red grows with the column, green with the row.
ColorImage ramp(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at(x, y) = {static_cast<uint8_t>(x), static_cast<uint8_t>(y), 7};
  }
  return image;
}

TEST(ResampleImage, ShiftsByWholePixels) {
  const Camera camera(CameraModel::kPinhole, 100, 80, {60, 60, 50, 40});
  const Camera view(CameraModel::kPinhole, 40, 30, {60, 60, 30, 25});  // begins at column 20, row 15
  const ResampleTable table = make_resample_table(camera, view, Eigen::Quaterniond::Identity());
  const ColorImage result = resample_image(ramp(100, 80), table, false);
  ASSERT_EQ(result.width, 40);
  ASSERT_EQ(result.height, 30);
  EXPECT_EQ(result.at(0, 0), (Rgb{20, 15, 7}));
  EXPECT_EQ(result.at(39, 29), (Rgb{59, 44, 7}));
}

TEST(ResampleImage, IsBlackWhereTheCameraShowsNothing) {
  const Camera camera(CameraModel::kPinhole, 100, 80, {60, 60, 50, 40});
  const Camera view(CameraModel::kPinhole, 120, 80, {60, 60, 60, 40});
  const ResampleTable table = make_resample_table(camera, view, Eigen::Quaterniond::Identity());
  const ColorImage result = resample_image(ramp(100, 80), table, false);
  EXPECT_EQ(result.at(9, 10), (Rgb{0, 0, 0}));
  EXPECT_EQ(result.at(10, 10), (Rgb{0, 10, 7}));
  EXPECT_EQ(result.at(110, 10), (Rgb{0, 0, 0}));
}

TEST(ResampleImage, PixelsAreWhereTheCameraProjectsThem) {
  const Camera camera(CameraModel::kSimpleRadial, 200, 150, {120, 100, 75, -0.15});
  const Camera view(CameraModel::kPinhole, 120, 90, {120, 120, 60, 45});
  const ResampleTable table = make_resample_table(camera, view, Eigen::Quaterniond::Identity());
  const ColorImage result = resample_image(ramp(200, 150), table, false);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(5, 5), Eigen::Vector2d(60, 45), Eigen::Vector2d(110, 80)}) {
    const Eigen::Vector2d expected = *camera.project(*view.unproject(pixel));
    const Rgb color = result.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    EXPECT_NEAR(color[0], expected.x(), 1.0);
    EXPECT_NEAR(color[1], expected.y(), 1.0);
  }
}

TEST(ResampleImage, GoesOnAcrossTheSeamOfAPanorama) {
  // One colour on the left half and one on the right half: straight behind the two meet.
  const Camera camera(CameraModel::kEquirectangular, 200, 100, {200, 100});
  ColorImage image(200, 100, Rgb{200, 0, 0});
  for (int y = 0; y < 100; ++y) {
    for (int x = 100; x < 200; ++x) image.at(x, y) = {0, 200, 0};
  }
  const Camera view(CameraModel::kPinhole, 64, 64, {32, 32, 31.5, 31.5});
  const Eigen::Quaterniond backwards(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()));
  const ResampleTable table = make_resample_table(camera, view, backwards);
  const ColorImage result = resample_image(image, table, true);
  // Looking back, the camera's right is on the left.
  EXPECT_EQ(result.at(20, 32), (Rgb{0, 200, 0}));
  EXPECT_EQ(result.at(44, 32), (Rgb{200, 0, 0}));
  for (int x = 0; x < 64; ++x) {
    const Rgb& color = result.at(x, 32);
    EXPECT_NEAR(color[0] + color[1], 200, 2) << x;
  }
}

}  // namespace
}  // namespace cpplus
