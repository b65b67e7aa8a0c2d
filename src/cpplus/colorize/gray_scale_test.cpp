#include "cpplus/colorize/gray_scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr Rgb kMid = {128, 128, 128};

TEST(GrayScale, ByHand) {
  // 101 intensities 0..100: the 99th percentile is 99.
  std::vector<float> intensities;
  for (int i = 100; i >= 0; --i) intensities.push_back(static_cast<float>(i));
  intensities.push_back(kNan);
  const GrayScale scale(intensities);
  EXPECT_EQ(scale.gray(0.0f), (Rgb{0, 0, 0}));
  EXPECT_EQ(scale.gray(49.5f), (Rgb{80, 80, 80}));
  EXPECT_EQ(scale.gray(99.0f), (Rgb{160, 160, 160}));
  EXPECT_EQ(scale.gray(100.0f), (Rgb{160, 160, 160}));
  EXPECT_EQ(scale.gray(-5.0f), (Rgb{0, 0, 0}));
  EXPECT_EQ(scale.gray(kNan), kMid);
}

TEST(GrayScale, MidGrayWhereIntensitiesSayNothing) {
  EXPECT_EQ(GrayScale().gray(7.0f), kMid);
  EXPECT_EQ(GrayScale(std::vector<float>{}).gray(7.0f), kMid);
  EXPECT_EQ(GrayScale(std::vector<float>{kNan, kNan}).gray(7.0f), kMid);
  EXPECT_EQ(GrayScale(std::vector<float>{0.0f, -0.0f, 0.0f}).gray(7.0f), kMid);
  EXPECT_EQ(GrayScale(std::vector<float>{-3.0f, -2.0f}).gray(7.0f), kMid);
}

TEST(GrayScale, ThePercentileIsThatOfTheSortedIntensities) {
  Random random(7);
  for (const size_t size : {1u, 2u, 99u, 100u, 5000u}) {
    std::vector<float> intensities;
    for (size_t i = 0; i < size; ++i) intensities.push_back(static_cast<float>(std::exp(3.0 * random.normal())));
    for (size_t i = 0; i < size / 3; ++i) intensities[i] *= -1.0f;
    std::vector<float> sorted = intensities;
    std::sort(sorted.begin(), sorted.end());
    const float percentile = sorted[static_cast<size_t>(0.99 * static_cast<double>(size - 1))];
    const GrayScale scale(intensities);
    // 100.5 of 160 is on the border between two greys.
    for (const double share : {100.499 / 160.0, 100.501 / 160.0, 0.25}) {
      const auto expected = static_cast<uint8_t>(std::lround(160.0 * share));
      EXPECT_EQ(scale.gray(static_cast<float>(share * percentile)), (Rgb{expected, expected, expected})) << size;
    }
  }
}

}  // namespace
}  // namespace cpplus
