#include "cpplus/colorize/cell_bearings.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

DepthBuffer buffer_of(double focal_px, double cell_px) {
  DepthBuffer buffer;
  buffer.camera = Camera(CameraModel::kSimpleRadial, 40, 30, {focal_px, 19.5, 14.5, -0.05});
  buffer.cell_px = cell_px;
  buffer.range = RangeImage(static_cast<int>(40 / cell_px), static_cast<int>(30 / cell_px));
  return buffer;
}

void expect_bearings_of(const DepthBuffer& buffer, const std::vector<Eigen::Vector3f>& bearings) {
  ASSERT_EQ(bearings.size(), buffer.range.pixels.size());
  for (int y = 0; y < buffer.range.height; ++y) {
    for (int x = 0; x < buffer.range.width; ++x) {
      const Eigen::Vector3d expected = *buffer.camera.unproject(buffer.center_of({x, y}));
      const auto i = static_cast<size_t>(y * buffer.range.width + x);
      EXPECT_LT((bearings[i].cast<double>() - expected).norm(), 1e-6) << x << " " << y;
    }
  }
}

TEST(CellBearings, PointAtTheCentresOfTheCells) {
  CellBearings bearings;
  expect_bearings_of(buffer_of(50, 2), bearings.of(buffer_of(50, 2)));
}

TEST(CellBearings, AreThoseOfTheBufferAskedForWhicheverCameFirst) {
  CellBearings bearings;
  for (int round = 0; round < 2; ++round) {
    for (int k = 0; k < 12; ++k) {  // more than are kept
      const DepthBuffer buffer = buffer_of(50 + k / 2, k % 2 == 0 ? 2 : 5);
      expect_bearings_of(buffer, bearings.of(buffer));
    }
  }
}

TEST(CellBearings, AreZeroWhereTheCameraSeesNothing) {
  DepthBuffer buffer = buffer_of(50, 2);
  buffer.camera = Camera(CameraModel::kSimpleRadial, 40, 30, {10.0, 19.5, 14.5, -0.3});  // folds within the image
  CellBearings bearings;
  EXPECT_TRUE(bearings.of(buffer).front().isZero());
  EXPECT_NEAR(bearings.of(buffer)[7 * 20 + 10].norm(), 1.0, 1e-6);
}

}  // namespace
}  // namespace cpplus
