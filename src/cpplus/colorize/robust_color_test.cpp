#include "cpplus/colorize/robust_color.h"

#include <gtest/gtest.h>

#include <vector>

namespace cpplus {
namespace {

RobustColor of(const std::vector<WeightedColor>& samples) { return robust_color(samples, 30.0); }

TEST(RobustColor, OneOutlierAmongThreeHasNoInfluence) {
  const RobustColor color = of({{{100, 50, 20}, 128}, {{255, 255, 255}, 128}, {{104, 52, 22}, 128}});
  EXPECT_EQ(color.color, (Rgb{102, 51, 21}));
  EXPECT_EQ(color.best, 0u);
}

TEST(RobustColor, AnOutlierThatWeighsMoreThanTheTwoOthersIsVotedOut) {
  // Somebody close to the camera stands before the wall that two other images show from farther away.
  EXPECT_EQ(of({{{20, 30, 90}, 250}, {{200, 190, 180}, 80}, {{204, 190, 180}, 80}}).color, (Rgb{202, 190, 180}));
  // Two that hardly count do not win against one that does.
  EXPECT_EQ(of({{{20, 30, 90}, 250}, {{200, 190, 180}, 10}, {{204, 190, 180}, 10}}).color, (Rgb{20, 30, 90}));
}

TEST(RobustColor, OfTwoContradictionsTheHeavierWinsUnmixed) {
  EXPECT_EQ(of({{{200, 200, 200}, 25}, {{50, 50, 50}, 230}}).color, (Rgb{50, 50, 50}));
  EXPECT_EQ(of({{{200, 200, 200}, 128}, {{50, 50, 50}, 128}}).color, (Rgb{200, 200, 200}));
}

TEST(RobustColor, AverageIsWeighted) {
  EXPECT_EQ(of({{{100, 0, 0}, 255}, {{110, 0, 0}, 85}}).color[0], 103);  // 102.5 rounded
}

TEST(RobustColor, SpreadIsTheRootMeanSquareDifferenceByHand) {
  // Mean (105, 0, 0); every sample is 5 levels off in one of three channels: sqrt(25 / 3) = 2.9.
  EXPECT_EQ(of({{{100, 0, 0}, 50}, {{110, 0, 0}, 50}}).spread, 3);
  // The outlier does not move the colour, but shows in the spread: sqrt(60^2 / 3).
  EXPECT_EQ(of({{{100, 50, 20}, 10}, {{100, 50, 20}, 10}, {{204, 50, 20}, 10}}).spread, 35);
  EXPECT_EQ(of({{{100, 50, 20}, 10}}).spread, 0);
}

TEST(RobustColor, BestIsTheHeaviestThatAgrees) {
  EXPECT_EQ(of({{{100, 0, 0}, 90}, {{250, 0, 0}, 200}, {{104, 0, 0}, 95}, {{102, 0, 0}, 60}}).best, 2u);
}

TEST(RobustColor, WithoutSamplesAllIsZero) {
  EXPECT_EQ(of({}).color, (Rgb{0, 0, 0}));
  EXPECT_EQ(of({}).spread, 0);
}

}  // namespace
}  // namespace cpplus
