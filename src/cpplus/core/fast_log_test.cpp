#include "cpplus/core/fast_log.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

TEST(FastLog2, PowersOfTwoAreExact) {
  for (int exponent = -100; exponent <= 100; ++exponent) {
    EXPECT_EQ(fast_log2(std::ldexp(1.0f, exponent)), static_cast<float>(exponent));
  }
}

TEST(FastLog2, IsWithinItsBound) {
  for (float value = 1e-6f; value < 1e9f; value *= 1.0007f) {
    ASSERT_NEAR(fast_log2(value), std::log2(static_cast<double>(value)), 2.5e-5) << value;
  }
}

}  // namespace
}  // namespace cpplus
