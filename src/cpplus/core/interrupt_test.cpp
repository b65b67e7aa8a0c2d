#include "cpplus/core/interrupt.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

class Interrupt : public testing::Test {
 protected:
  ~Interrupt() override { clear_interrupt(); }
};

TEST_F(Interrupt, NothingHappensUnasked) {
  EXPECT_FALSE(interrupt_requested());
  EXPECT_NO_THROW(check_interrupt());
}

TEST_F(Interrupt, ASignalIsARequest) {
  stop_on_signals();
  std::raise(SIGINT);
  EXPECT_TRUE(interrupt_requested());
  EXPECT_THROW(check_interrupt(), Interrupted);
}

TEST_F(Interrupt, ParallelLoopsStopBeforeTheNextItem) {
  set_num_threads(1);
  std::atomic<int> done{0};
  const auto loop = [&] {
    parallel_for_each(100, [&](size_t) {
      if (++done == 3) request_interrupt();
    });
  };
  EXPECT_THROW(loop(), Interrupted);
  EXPECT_EQ(done, 3);
  set_num_threads(0);
}

}  // namespace
}  // namespace cpplus
