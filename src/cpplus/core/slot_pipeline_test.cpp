#include "cpplus/core/slot_pipeline.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "cpplus/core/interrupt.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

class SlotPipelineTest : public ::testing::Test {
 protected:
  void TearDown() override {
    set_num_threads(0);
    clear_interrupt();
  }
};

/// Takes 0, 1, ... size - 1, adds a hundred to each in parallel, and collects them.
struct Numbers {
  size_t size;
  size_t num_slots;
  size_t next = 0;
  std::vector<size_t> slots = std::vector<size_t>(num_slots);
  std::vector<size_t> put_values = {};
  std::atomic<size_t> num_finished{0};

  PipelineStages stages() {
    return {[this](size_t slot) {
              if (next == size) return false;
              slots[slot] = next++;
              return true;
            },
            [this](size_t slot) {
              // The later item of two is done first.
              if (slots[slot] % 2 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
              slots[slot] += 100;
            },
            [this](size_t slot) { put_values.push_back(slots[slot]); }, [this](size_t) { ++num_finished; }};
  }
};

TEST_F(SlotPipelineTest, PutsAllItemsInTheOrderOfTakingWithAnyNumberOfThreads) {
  std::vector<size_t> expected(50);
  std::iota(expected.begin(), expected.end(), size_t{100});
  for (const int threads : {1, 2, 4}) {
    set_num_threads(threads);
    for (const size_t num_slots : {size_t{1}, size_t{3}}) {
      Numbers numbers{expected.size(), num_slots};
      run_slot_pipeline(num_slots, numbers.stages());
      EXPECT_EQ(numbers.put_values, expected) << threads << " threads";
      EXPECT_EQ(numbers.num_finished, expected.size());
    }
  }
}

TEST_F(SlotPipelineTest, NothingToTakeIsNothingToDo) {
  Numbers numbers{0, 2};
  run_slot_pipeline(2, numbers.stages());
  EXPECT_TRUE(numbers.put_values.empty());
}

TEST_F(SlotPipelineTest, LastStageMayBeLeftOut) {
  Numbers numbers{5, 2};
  PipelineStages stages = numbers.stages();
  stages.finish = nullptr;
  run_slot_pipeline(2, stages);
  EXPECT_EQ(numbers.put_values.size(), 5u);
}

TEST_F(SlotPipelineTest, NoSlotHoldsTwoItemsAtATime) {
  set_num_threads(4);
  std::vector<std::atomic<int>> users(3);
  size_t num_taken = 0;
  run_slot_pipeline(users.size(), {[&](size_t slot) {
                                     EXPECT_EQ(users[slot]++, 0);
                                     return ++num_taken <= 200;
                                   },
                                   [](size_t) {}, [](size_t) {}, [&](size_t slot) { --users[slot]; }});
}

TEST_F(SlotPipelineTest, RethrowsTheExceptionOfTheFirstItemAndPutsNothingBehindIt) {
  for (const int threads : {1, 2, 4}) {
    set_num_threads(threads);
    Numbers numbers{50, 4};
    PipelineStages stages = numbers.stages();
    stages.work = [&](size_t slot) {
      const size_t item = numbers.slots[slot];
      if (item < 7) return;
      // The first one is the slowest, so that others fail before it.
      if (item == 7) std::this_thread::sleep_for(std::chrono::milliseconds(20));
      throw std::runtime_error(std::to_string(item));
    };
    try {
      run_slot_pipeline(4, stages);
      FAIL() << threads << " threads";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "7") << threads << " threads";
    }
    EXPECT_EQ(numbers.put_values.size(), 7u);
    EXPECT_EQ(numbers.num_finished, 7u);
  }
}

TEST_F(SlotPipelineTest, ItemsBeforeAFailedTakeAreAllPut) {
  for (const int threads : {1, 3}) {
    set_num_threads(threads);
    Numbers numbers{50, 4};
    PipelineStages stages = numbers.stages();
    const auto take = stages.take;
    stages.take = [&](size_t slot) {
      if (numbers.next == 9) throw std::runtime_error("nine");
      return take(slot);
    };
    EXPECT_THROW(run_slot_pipeline(4, stages), std::runtime_error);
    EXPECT_EQ(numbers.put_values.size(), 9u);
  }
}

TEST_F(SlotPipelineTest, StopsWhereAskedTo) {
  Numbers numbers{50, 2};
  PipelineStages stages = numbers.stages();
  const auto put = stages.put;
  stages.put = [&](size_t slot) {
    put(slot);
    if (numbers.put_values.size() == 3) request_interrupt();
  };
  EXPECT_THROW(run_slot_pipeline(2, stages), Interrupted);
  EXPECT_LE(numbers.put_values.size(), 5u);
}

}  // namespace
}  // namespace cpplus
