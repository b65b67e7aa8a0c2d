#include "cpplus/core/for_each_set.h"

#include <gtest/gtest.h>

#include <vector>

namespace cpplus {
namespace {

std::vector<size_t> set_of(const std::vector<uint8_t>& bytes) {
  std::vector<size_t> set;
  for_each_set(bytes.data(), bytes.size(), [&](size_t i) { set.push_back(i); });
  return set;
}

TEST(ForEachSet, VisitsWhatIsNotZero) {
  EXPECT_EQ(set_of({0, 1, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 16, 0, 3}), (std::vector<size_t>{1, 3, 16, 18}));
  EXPECT_EQ(set_of({1, 1, 1, 1, 1, 1, 1, 1}), (std::vector<size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_TRUE(set_of(std::vector<uint8_t>(100, 0)).empty());
  EXPECT_TRUE(set_of({}).empty());
}

}  // namespace
}  // namespace cpplus
