#include "cpplus/colorize/color_samples.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

constexpr double kMaxDeviation = 30.0;

TEST(ColorSamples, OneOutlierAmongThreeHasNoInfluence) {
  ColorSamples samples(1, 8);
  samples.add(0, {100, 50, 20}, 0.5);
  samples.add(0, {255, 255, 255}, 0.5);
  samples.add(0, {104, 52, 22}, 0.5);
  EXPECT_EQ(samples.color(0, kMaxDeviation), (Rgb{102, 51, 21}));
  EXPECT_EQ(samples.num_views(0), 3);
}

TEST(ColorSamples, AverageIsWeighted) {
  ColorSamples samples(1, 8);
  samples.add(0, {100, 0, 0}, 1.0);                    // 255
  samples.add(0, {110, 0, 0}, 85.0 / 255.0);           // a third of it
  EXPECT_EQ(samples.color(0, kMaxDeviation)[0], 103);  // 102.5 rounded
}

TEST(ColorSamples, HeavySampleWinsAgainstALightContradiction) {
  ColorSamples samples(1, 8);
  samples.add(0, {200, 200, 200}, 0.1);
  samples.add(0, {50, 50, 50}, 0.9);
  EXPECT_EQ(samples.color(0, kMaxDeviation), (Rgb{50, 50, 50}));
}

TEST(ColorSamples, TwoEquallyHeavyContradictionsGiveTheMiddle) {
  ColorSamples samples(1, 8);
  samples.add(0, {200, 200, 200}, 0.5);
  samples.add(0, {50, 50, 50}, 0.5);
  EXPECT_EQ(samples.color(0, kMaxDeviation), (Rgb{125, 125, 125}));
}

TEST(ColorSamples, AFullPointKeepsItsHeaviestSamplesAndCountsAllViews) {
  ColorSamples samples(2, 2);
  samples.add(1, {10, 10, 10}, 0.2);
  samples.add(1, {90, 90, 90}, 0.8);
  samples.add(1, {90, 90, 90}, 0.7);  // replaces the first
  samples.add(1, {0, 0, 0}, 0.7);     // equally heavy: comes too late
  EXPECT_EQ(samples.color(1, 0.0), (Rgb{90, 90, 90}));
  EXPECT_EQ(samples.num_views(1), 4);
  EXPECT_EQ(samples.num_views(0), 0);
  EXPECT_EQ(samples.color(0, kMaxDeviation), (Rgb{0, 0, 0}));
}

TEST(ColorSamples, TheTinyestWeightStillCounts) {
  ColorSamples samples(1, 2);
  samples.add(0, {7, 8, 9}, 1e-9);
  EXPECT_EQ(samples.color(0, kMaxDeviation), (Rgb{7, 8, 9}));
}

}  // namespace
}  // namespace cpplus
