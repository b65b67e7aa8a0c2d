#include "cpplus/features/seen_points.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

const Camera kCamera(CameraModel::kOpenCv, 640, 480, {400, 410, 320, 240, -0.2, 0.05, 0.001, -0.002});
constexpr int kColumns = 320;
constexpr int kRows = 240;

// A raster that shows something 2 m away in its left half, with two points in every other cell of each row.
RangeRaster striped_raster() {
  RangeRaster raster;
  raster.range = RangeImage(kColumns, kRows, 0.0f);
  raster.points.begin = {0};
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      if (x < kColumns / 2) raster.range.at(x, y) = 2.0f;
      if (x % 2 == 0) {
        const Eigen::Vector2f corner = raster.corner_of({x, y}).cast<float>();
        raster.points.points.push_back({corner + Eigen::Vector2f(0.3f, 0.6f), 2.1f});
        raster.points.points.push_back({corner + Eigen::Vector2f(1.7f, 1.1f), 5.0f});
      }
      raster.points.begin.push_back(static_cast<uint32_t>(raster.points.points.size()));
    }
  }
  return raster;
}

TEST(PointsAround, AreThoseOfTheSquare) {
  // Pixels 190 to 210 and 90 to 110: cells 95 to 105 and 45 to 55, of whose eleven columns five are even.
  const SeenSquare square = points_around(kCamera, striped_raster(), {200, 100}, 10.0);
  EXPECT_EQ(square.num_cells, 5u * 11u);
  ASSERT_EQ(square.points.size(), 2u * 5u * 11u);
  EXPECT_EQ(square.share_filled, 1.0);
  for (size_t i = 0; i < square.points.size(); ++i) {
    EXPECT_EQ(square.points[i].cell, i / 2);
    EXPECT_EQ(square.points[i].nearest, 2.0);
    EXPECT_NEAR(square.points[i].range, i % 2 == 0 ? 2.1 : 5.0, 1e-6);
  }
}

TEST(PointsAround, BearingsAreThoseOfTheCamera) {
  const RangeRaster raster = striped_raster();
  const SeenSquare square = points_around(kCamera, raster, {60, 50}, 10.0);
  ASSERT_FALSE(square.points.empty());
  size_t i = 0;
  for (int y = 20; y <= 30; ++y) {
    for (int x = 25; x <= 35; ++x) {
      for (const auto& point : raster.points_in({x, y})) {
        const Eigen::Vector3d bearing = *kCamera.unproject(point.pixel.cast<double>());
        // Three millimetres at 10 m, near the corner of a distorted image.
        EXPECT_LT((square.points[i].bearing - bearing).norm(), 4e-4);
        EXPECT_NEAR(square.points[i++].bearing.norm(), 1.0, 1e-12);
      }
    }
  }
  EXPECT_EQ(i, square.points.size());
}

TEST(PointsAround, CellsThatShowNothingHaveNone) {
  // Cells 155 to 165: five of eleven columns show something.
  const SeenSquare square = points_around(kCamera, striped_raster(), {320, 100}, 10.0);
  EXPECT_NEAR(square.share_filled, 5.0 / 11.0, 1e-12);
  EXPECT_EQ(square.num_cells, 2u * 11u);  // 156 and 158
}

TEST(PointsAround, EmptyAtTheEdgeOfTheImageOrWithoutABearing) {
  const SeenSquare corner = points_around(kCamera, striped_raster(), {0, 0}, 10.0);
  EXPECT_LT(corner.share_filled, 0.5);
  const Camera fisheye(CameraModel::kOpenCvFisheye, 640, 480, {200, 200, 320, 240, 0.0, 0.0, 0.0, 0.0});
  EXPECT_TRUE(points_around(fisheye, striped_raster(), {1e6, 1e6}, 10.0).points.empty());
}

}  // namespace
}  // namespace cpplus
