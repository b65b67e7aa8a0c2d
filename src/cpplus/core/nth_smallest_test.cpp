#include "cpplus/core/nth_smallest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

TEST(NthSmallest, IsWhatSortingPutsThere) {
  Random random(1);
  std::vector<float> values = {0.0f, 0.0f, 1e-40f, 1.0f, 1.0f, 3e38f, std::numeric_limits<float>::infinity()};
  for (int i = 0; i < 200; ++i) values.push_back(static_cast<float>(std::exp(random.uniform(-20.0, 20.0))));
  for (int i = 0; i < 200; ++i) values.push_back(1.0f + 1e-7f * static_cast<float>(random.below(20)));
  std::vector<float> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (size_t rank = 0; rank < values.size(); ++rank) EXPECT_EQ(nth_smallest(values, rank), sorted[rank]) << rank;
}

TEST(NthSmallest, OfOneIsThatOne) { EXPECT_EQ(nth_smallest(std::vector{2.5f}, 0), 2.5f); }

}  // namespace
}  // namespace cpplus
