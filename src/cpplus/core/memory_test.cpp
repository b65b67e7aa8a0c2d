#include "cpplus/core/memory.h"

#include <gtest/gtest.h>

#include <vector>

namespace cpplus {
namespace {

TEST(FreeMemory, LeavesAVectorWithoutMemory) {
  std::vector<int> values(1000, 1);
  free_memory(&values);
  EXPECT_TRUE(values.empty());
  EXPECT_EQ(values.capacity(), 0u);
  free_memory(&values);  // of none
  EXPECT_EQ(values.capacity(), 0u);
}

}  // namespace
}  // namespace cpplus
