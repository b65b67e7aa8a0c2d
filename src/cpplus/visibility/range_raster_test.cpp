#include "cpplus/visibility/range_raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

constexpr int kWidth = 57;
constexpr int kHeight = 41;

Camera camera() { return Camera(CameraModel::kPinhole, 2 * kWidth, 2 * kHeight, {100, 100, 57, 41}); }

ProjectedPoint point_in(int column, int row, float range, float spacing_px) {
  const Eigen::Vector2f middle(2.0f * static_cast<float>(column) + 0.5f, 2.0f * static_cast<float>(row) + 0.5f);
  return {middle, range, spacing_px};
}

int half_cells(float spacing_px) { return std::clamp(static_cast<int>(spacing_px / 2.0f + 0.5f), 1, 12); }

int column_of(const ProjectedPoint& point) { return static_cast<int>(point.pixel.x() + 0.5f) / 2; }
int row_of(const ProjectedPoint& point) { return static_cast<int>(point.pixel.y() + 0.5f) / 2; }

// Without those that lie behind another one in the same cell.
std::vector<ProjectedPoint> nearest_of_cells(const std::vector<ProjectedPoint>& points) {
  std::vector<ProjectedPoint> nearest;
  for (const ProjectedPoint& point : points) {
    const bool is_behind = std::any_of(points.begin(), points.end(), [&](const ProjectedPoint& other) {
      return column_of(other) == column_of(point) && row_of(other) == row_of(point) && other.range < point.range;
    });
    if (!is_behind) nearest.push_back(point);
  }
  return nearest;
}

// Cell by cell, as the definition has it: squares drawn, then shrunk by the square of what each cell shows.
RangeImage closed(const std::vector<ProjectedPoint>& points) {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  RangeImage range(kWidth, kHeight, kNothing);
  Image<int> half(kWidth, kHeight, 0);
  for (const ProjectedPoint& point : nearest_of_cells(points)) {
    const int h = half_cells(point.spacing_px);
    const int column = column_of(point);
    const int row = row_of(point);
    for (int y = std::max(0, row - h); y <= std::min(kHeight - 1, row + h); ++y) {
      for (int x = std::max(0, column - h); x <= std::min(kWidth - 1, column + h); ++x) {
        if (point.range >= range.at(x, y)) continue;
        range.at(x, y) = point.range;
        half.at(x, y) = h;
      }
    }
  }
  RangeImage result(kWidth, kHeight, 0.0f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      float farthest = half.at(x, y) > 0 ? 0.0f : kNothing;
      for (int v = y - half.at(x, y); v <= y + half.at(x, y); ++v) {
        // Rows first, then columns: each row shrinks by its own cell's square.
        if (v < 0 || v >= kHeight || half.at(x, y) == 0) continue;
        float along = half.at(x, v) > 0 ? 0.0f : kNothing;
        for (int u = std::max(0, x - half.at(x, v)); u <= std::min(kWidth - 1, x + half.at(x, v)); ++u) {
          if (half.at(x, v) > 0) along = std::max(along, range.at(u, v));
        }
        farthest = std::max(farthest, along);
      }
      result.at(x, y) = farthest == kNothing ? 0.0f : farthest;
    }
  }
  return result;
}

RangeRaster draw_range_raster(std::span<const ProjectedPoint> points) {
  RangeRasterDrawer drawer(camera(), 2.0);
  std::vector<uint32_t> cells(points.size());
  drawer.add(points, cells.data());
  return std::move(drawer).finish();
}

TEST(DrawRangeRaster, OnePointKeepsItsCell) {
  const RangeRaster raster = draw_range_raster(std::vector{point_in(20, 10, 5.0f, 3.0f)});
  ASSERT_EQ(raster.range.width, kWidth);
  ASSERT_EQ(raster.range.height, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(raster.range.at(x, y), x == 20 && y == 10 ? 5.0f : 0.0f);
      const bool in_square = std::abs(x - 20) <= 2 && std::abs(y - 10) <= 2;
      EXPECT_EQ(raster.spacing_px.at(x, y), in_square ? 3.0f : 0.0f);
    }
  }
}

TEST(DrawRangeRaster, AGapOfTwoSpacingsIsClosedAndTheNearerOfTwoIsSeen) {
  const std::vector<ProjectedPoint> points = {point_in(20, 10, 5.0f, 4.0f), point_in(24, 10, 5.1f, 4.0f),
                                              point_in(20, 10, 7.0f, 4.0f)};
  const RangeRaster raster = draw_range_raster(points);
  for (int x = 20; x <= 24; ++x) EXPECT_NEAR(raster.range.at(x, 10), 5.05f, 0.06f) << x;
  EXPECT_EQ(raster.range.at(19, 10), 0.0f);
  EXPECT_EQ(raster.range.at(25, 10), 0.0f);
}

TEST(DrawRangeRaster, IsAsTheDefinitionHasIt) {
  Random random(3);
  for (const float largest_px : {2.0f, 9.0f, 40.0f}) {
    std::vector<ProjectedPoint> points;
    for (int i = 0; i < 150; ++i) {
      points.push_back(point_in(static_cast<int>(random.below(kWidth)), static_cast<int>(random.below(kHeight)),
                                static_cast<float>(random.uniform(2, 9)),
                                largest_px * static_cast<float>(random.uniform())));
    }
    EXPECT_EQ(draw_range_raster(points).range.pixels, closed(points).pixels) << largest_px;
  }
}

TEST(DrawRangeRaster, PointsHandedOverInPartsGiveTheSame) {
  Random random(4);
  std::vector<ProjectedPoint> points;
  for (int i = 0; i < 300; ++i) {
    points.push_back({Eigen::Vector2d(random.uniform(0, 113), random.uniform(0, 81)).cast<float>(),
                      static_cast<float>(random.uniform(2, 9)), static_cast<float>(random.uniform(0, 6))});
  }
  RangeRasterDrawer drawer(camera(), 2.0);
  const std::span<const ProjectedPoint> all(points);
  std::vector<uint32_t> cells(points.size());
  drawer.add(all.first(100), cells.data());
  drawer.add(all.subspan(100), cells.data() + 100);
  for (size_t i = 0; i < points.size(); ++i) {
    const int column = static_cast<int>(points[i].pixel.x() + 0.5f) / 2;
    const int row = static_cast<int>(points[i].pixel.y() + 0.5f) / 2;
    EXPECT_EQ(cells[i], static_cast<uint32_t>(row * kWidth + column)) << i;
  }
  const RangeRaster raster = std::move(drawer).finish();
  EXPECT_EQ(raster.range.pixels, draw_range_raster(points).range.pixels);
}

TEST(DrawRangeRaster, NoPointsShowNothing) {
  for (const float range : draw_range_raster({}).range.pixels) EXPECT_EQ(range, 0.0f);
}

TEST(AddPointsByCell, EachPointIsInItsCellHiddenOnesToo) {
  PointsInView view;
  Random random(3);
  RangeRasterDrawer drawer(camera(), 2.0);
  for (int i = 0; i < 300; ++i) {
    view.points.push_back(point_in(static_cast<int>(random.uniform(0, kWidth)),
                                   static_cast<int>(random.uniform(0, kHeight)),
                                   static_cast<float>(random.uniform(1.0, 9.0)), 2.0f));
  }
  view.cells.resize(view.points.size());
  drawer.add(view.points, view.cells.data());
  view.raster = std::move(drawer).finish();
  EXPECT_TRUE(view.raster.points_in({3, 3}).empty()) << "not asked for";
  add_points_by_cell(0.02, &view);
  EXPECT_EQ(view.raster.points.noise_m, 0.02);
  size_t num_points = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto in_cell = view.raster.points_in({x, y});
      num_points += in_cell.size();
      const auto expected = std::count_if(view.points.begin(), view.points.end(), [&](const ProjectedPoint& point) {
        return column_of(point) == x && row_of(point) == y;
      });
      EXPECT_EQ(static_cast<std::ptrdiff_t>(in_cell.size()), expected);
      for (const auto& point : in_cell) EXPECT_EQ(view.raster.cell_of(point.pixel), Eigen::Vector2i(x, y));
    }
  }
  EXPECT_EQ(num_points, view.points.size());
  EXPECT_TRUE(view.raster.points_in({-1, 0}).empty());
  EXPECT_TRUE(view.raster.points_in({0, kHeight}).empty());
}

}  // namespace
}  // namespace cpplus
