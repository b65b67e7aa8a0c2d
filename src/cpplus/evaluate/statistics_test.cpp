#include "cpplus/evaluate/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

TEST(SampleStatistics, OfFourNumbersByHand) {
  const SampleStatistics s = sample_statistics({7, 1, 5, 1});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 3.5);
  EXPECT_DOUBLE_EQ(s.median, 3.0);
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(76.0 / 4.0));
  EXPECT_DOUBLE_EQ(s.max, 7.0);
}

TEST(SampleStatistics, OfAnOddCountTakesTheMiddleOne) { EXPECT_DOUBLE_EQ(sample_statistics({9, 2, 4}).median, 4.0); }

TEST(SampleStatistics, OfNothingAreNan) {
  const SampleStatistics s = sample_statistics({});
  EXPECT_EQ(s.count, 0u);
  EXPECT_TRUE(std::isnan(s.mean) && std::isnan(s.median) && std::isnan(s.rms) && std::isnan(s.max));
}

TEST(SuccessShares, CountStrictlyBelowOneTwoAndFivePixels) {
  const auto shares = success_shares({0.5, 1.0, 1.5, 3.0, 5.0});
  EXPECT_DOUBLE_EQ(shares[0], 0.2);
  EXPECT_DOUBLE_EQ(shares[1], 0.6);
  EXPECT_DOUBLE_EQ(shares[2], 0.8);
}

TEST(SuccessShares, OfNothingAreNan) { EXPECT_TRUE(std::isnan(success_shares({})[0])); }

}  // namespace
}  // namespace cpplus
