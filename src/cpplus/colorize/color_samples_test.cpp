#include "cpplus/colorize/color_samples.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

static_assert(sizeof(ColorSample) == 8, "the memory bound in docs/colorize.md counts on it");

TEST(ColorSamples, AFullPointKeepsItsHeaviestSamplesAndCountsAllViews) {
  ColorSamples samples(2, 2);
  samples.add(1, {{10, 10, 10}, 50, 0, 0});
  samples.add(1, {{90, 90, 90}, 200, 1, 7});
  samples.add(1, {{91, 90, 90}, 180, 2, 9});  // replaces the first
  samples.add(1, {{0, 0, 0}, 180, 3, 0});     // equally heavy: comes too late
  ASSERT_EQ(samples.of_point(1).size(), 2u);
  EXPECT_EQ(samples.of_point(1)[0].image, 1);
  EXPECT_EQ(samples.of_point(1)[1].image, 2);
  EXPECT_EQ(samples.of_point(1)[1].color, (Rgb{91, 90, 90}));
  EXPECT_EQ(samples.of_point(1)[1].radius, 9);
  EXPECT_EQ(samples.num_views(1), 4);
  EXPECT_EQ(samples.num_views(0), 0);
  EXPECT_TRUE(samples.of_point(0).empty());
}

}  // namespace
}  // namespace cpplus
