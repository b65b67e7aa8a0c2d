#include "cpplus/visibility/outline_chains.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

// A wall at 10 m that fills the view of 40 x 30 cells.
RangeRaster wall() {
  RangeRaster raster;
  raster.range = RangeImage(40, 30, 10.0f);
  raster.spacing_px = RangeImage(40, 30, 1.0f);
  return raster;
}

void fill(int x0, int y0, int x1, int y1, float range, RangeRaster* raster) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) raster->range.at(x, y) = range;
  }
}

TEST(TraceOutlines, ARectangleInFrontIsOneClosedChainOfFourStretches) {
  RangeRaster raster = wall();
  fill(10, 8, 22, 18, 5.0f, &raster);
  const auto chains = trace_outlines(raster, {});
  ASSERT_EQ(chains.size(), 1u);
  EXPECT_EQ(chains[0].size(), 2u * (12 + 10));
  for (const OutlineStep& step : chains[0]) {
    EXPECT_EQ(step.range, 5.0f);
    // Cells of 2 px from -0.5 px on: the rectangle covers 19.5 to 43.5 px by 15.5 to 35.5 px.
    const double dx = std::min(std::abs(step.pixel.x() - 19.5), std::abs(step.pixel.x() - 43.5));
    const double dy = std::min(std::abs(step.pixel.y() - 15.5), std::abs(step.pixel.y() - 35.5));
    EXPECT_NEAR(std::min(dx, dy), 0.0, 1e-9);
  }
  double length = 0.0;
  for (const ChainStretch& stretch : straight_stretches(chains[0], 1.5)) {
    length += (chains[0][stretch.end - 1].pixel - chains[0][stretch.begin].pixel).norm();
  }
  EXPECT_NEAR(length, 2 * (24 + 20), 10.0);
}

TEST(TraceOutlines, TheNearSurfaceIsOnTheRight) {
  RangeRaster raster = wall();
  fill(0, 0, 20, 30, 5.0f, &raster);
  const auto chains = trace_outlines(raster, {});
  ASSERT_EQ(chains.size(), 1u);
  ASSERT_EQ(chains[0].size(), 30u);
  // Near on the left of the image: downwards it is on the right-hand side.
  EXPECT_GT(chains[0].back().pixel.y(), chains[0].front().pixel.y());
}

TEST(TraceOutlines, NothingBeyondIsNoOutline) {
  RangeRaster raster = wall();
  fill(0, 0, 20, 30, 5.0f, &raster);
  fill(20, 0, 40, 30, 0.0f, &raster);
  EXPECT_TRUE(trace_outlines(raster, {}).empty());
}

TEST(TraceOutlines, AnEmptyStripBeforeTheFarSurfaceIsPassedOver) {
  // The LiDAR stood elsewhere: the strip is in the near surface's shadow.
  RangeRaster raster = wall();
  fill(0, 0, 12, 30, 5.0f, &raster);
  fill(12, 0, 20, 30, 0.0f, &raster);
  const auto chains = trace_outlines(raster, {});
  ASSERT_EQ(chains.size(), 1u);
  EXPECT_EQ(chains[0].size(), 30u);
  for (const OutlineStep& step : chains[0]) EXPECT_NEAR(step.pixel.x(), 23.5, 1e-9);
}

TEST(TraceOutlines, BeforeSomethingNearerTheStripIsItsShadow) {
  RangeRaster raster = wall();
  fill(0, 0, 12, 30, 5.0f, &raster);
  fill(12, 0, 20, 30, 0.0f, &raster);
  fill(20, 0, 40, 30, 3.0f, &raster);
  // The outline is that of what casts the shadow.
  const auto chains = trace_outlines(raster, {});
  ASSERT_EQ(chains.size(), 1u);
  for (const OutlineStep& step : chains[0]) EXPECT_EQ(step.range, 3.0f);
}

TEST(TraceOutlines, ANarrowGapIsNoOutline) {
  RangeRaster raster = wall();
  fill(0, 0, 40, 30, 5.0f, &raster);
  fill(20, 0, 22, 30, 10.0f, &raster);
  EXPECT_TRUE(trace_outlines(raster, {}).empty());
}

TEST(TraceOutlines, AGrazingFloorHasNoOutline) {
  // 1.6 m below a camera of 700 px focal length: 0.3 m from cell to cell at 12 m, 3 m at 37 m.
  RangeRaster raster = wall();
  for (int y = 0; y < 30; ++y) fill(0, y, 40, y + 1, static_cast<float>(1.6 * 700 / (2.0 * y + 30)), &raster);
  EXPECT_GT(raster.range.at(0, 0) - raster.range.at(0, 1), 2.0f);
  EXPECT_TRUE(trace_outlines(raster, {}).empty());
}

TEST(StraightStretches, ABendCutsAChain) {
  std::vector<OutlineStep> chain(41);
  for (int i = 0; i <= 40; ++i) chain[static_cast<size_t>(i)].pixel = {i <= 20 ? i : 20.0, i <= 20 ? 0.0 : i - 20.0};
  const auto stretches = straight_stretches(chain, 1.0);
  ASSERT_EQ(stretches.size(), 2u);
  EXPECT_EQ(stretches[0].begin, 0u);
  EXPECT_EQ(stretches[0].end, 21u);
  EXPECT_EQ(stretches[1].begin, 20u);
  EXPECT_EQ(stretches[1].end, 41u);
  EXPECT_TRUE(straight_stretches({}, 1.0).empty());
}

TEST(RangeJumpOptions, ValuesOutOfRangeAreErrors) {
  RangeJumpOptions options;
  EXPECT_NO_THROW(options.validate());
  options.min_jump_m = 0.0;
  EXPECT_THROW(options.validate(), Error);
}

}  // namespace
}  // namespace cpplus
