#include "cpplus/features/segments_2d.h"

#include <gtest/gtest.h>

#include "cpplus/features/grid_2d.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;

/// A point every 5 cm from start to end, both included.
void add_row(const Vector2d& start, const Vector2d& end, const Vector2d& normal, std::vector<DirectedPoint2d>* points) {
  const int steps = static_cast<int>(std::lround((end - start).norm() / 0.05));
  for (int k = 0; k <= steps; ++k) points->push_back({start + static_cast<double>(k) / steps * (end - start), normal});
}

TEST(Segments2d, TwoSidesOfASquareByHand) {
  std::vector<DirectedPoint2d> points;
  add_row({0, 0}, {1, 0}, {0, 1}, &points);
  add_row({0, 0.05}, {0, 1.05}, {1, 0}, &points);
  const auto segments = find_segments(points, {});
  ASSERT_EQ(segments.size(), 2u);
  const bool first_is_x = std::abs(segments[0].normal.y()) > 0.5;
  const Segment2d& along_x = segments[first_is_x ? 0 : 1];
  const Segment2d& along_y = segments[first_is_x ? 1 : 0];
  EXPECT_NEAR(along_x.normal.y(), 1.0, 1e-9);
  EXPECT_NEAR(along_y.normal.x(), 1.0, 1e-9);
  EXPECT_NEAR((along_x.end - along_x.start).norm(), 1.0, 1e-9);
  EXPECT_NEAR((along_y.end - along_y.start).norm(), 1.0, 1e-9);
  EXPECT_NEAR(std::abs(along_x.start.y()), 0.0, 1e-9);
  EXPECT_NEAR(std::min(along_x.start.x(), along_x.end.x()), 0.0, 1e-9);
}

TEST(Segments2d, AGapSplitsARow) {
  std::vector<DirectedPoint2d> points;
  add_row({0, 0}, {1, 0}, {0, 1}, &points);
  add_row({1.3, 0}, {2, 0}, {0, 1}, &points);
  EXPECT_EQ(find_segments(points, {}).size(), 2u);
  Segment2dOptions wide;
  wide.max_gap_m = 0.35;
  EXPECT_EQ(find_segments(points, wide).size(), 1u);
}

TEST(Segments2d, RowsThatFaceEachOtherStayApart) {
  std::vector<DirectedPoint2d> points;
  add_row({0, 0}, {1, 0}, {0, 1}, &points);
  add_row({0, 0.01}, {1, 0.01}, {0, -1}, &points);
  const auto segments = find_segments(points, {});
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_NEAR(segments[0].normal.dot(segments[1].normal), -1.0, 1e-9);
}

TEST(Segments2d, ShortRowsAndNothingGiveNothing) {
  EXPECT_TRUE(find_segments({}, {}).empty());
  std::vector<DirectedPoint2d> points;
  add_row({0, 0}, {0.2, 0}, {0, 1}, &points);
  EXPECT_TRUE(find_segments(points, {}).empty());
}

TEST(Grid2d, FindsEveryPointNear) {
  std::vector<Vector2d> points;
  for (int i = 0; i < 20; ++i) points.emplace_back(0.1 * i, 0.05 * i);
  const Grid2d grid(points, 0.3);
  for (const Vector2d& x : {Vector2d(0.5, 0.3), Vector2d(-5.0, 0.0), Vector2d(1.9, 0.95)}) {
    size_t near = 0;
    size_t expected = 0;
    grid.for_each_near(x, 0.25, [&](uint32_t i) { near += (points[i] - x).norm() < 0.25; });
    for (const Vector2d& p : points) expected += (p - x).norm() < 0.25;
    EXPECT_EQ(near, expected);
  }
}

}  // namespace
}  // namespace cpplus
