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

TEST(ColorSamples, TakeTheirNewImagesAndAreRestored) {
  ColorSamples samples(2, 2);
  samples.add(0, {{10, 10, 10}, 50, 3, 0});
  samples.add(1, {{20, 20, 20}, 50, 1, 0});
  samples.add(1, {{30, 30, 30}, 60, 3, 0});
  samples.renumber_images(std::vector<uint16_t>{0, 0, 7, 1});
  EXPECT_EQ(samples.of_point(0)[0].image, 1);
  EXPECT_EQ(samples.of_point(1)[0].image, 0);
  EXPECT_EQ(samples.of_point(1)[1].image, 1);
  ColorSamples restored(2, 2);
  restored.restore(0, samples.of_point(1), 9);
  ASSERT_EQ(restored.of_point(0).size(), 2u);
  EXPECT_EQ(restored.of_point(0)[1].color, (Rgb{30, 30, 30}));
  EXPECT_EQ(restored.num_views(0), 9);
  EXPECT_TRUE(restored.of_point(1).empty());
}

}  // namespace
}  // namespace cpplus
