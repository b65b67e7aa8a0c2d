#include "cpplus/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace cpplus {
namespace {

class Parallel : public ::testing::Test {
 protected:
  void TearDown() override { set_num_threads(0); }
};

std::set<std::pair<size_t, size_t>> chunks_of(size_t size, size_t grain) {
  std::mutex mutex;
  std::set<std::pair<size_t, size_t>> chunks;
  parallel_for_chunks(size, grain, [&](size_t begin, size_t end) {
    const std::lock_guard lock(mutex);
    EXPECT_TRUE(chunks.insert({begin, end}).second);
  });
  return chunks;
}

TEST_F(Parallel, ChunksByHand) {
  const std::set<std::pair<size_t, size_t>> expected = {{0, 4}, {4, 8}, {8, 10}};
  for (int threads : {1, 2, 4}) {
    set_num_threads(threads);
    EXPECT_EQ(chunks_of(10, 4), expected) << threads << " threads";
  }
  EXPECT_EQ(chunks_of(4, 4).size(), 1u);
  EXPECT_EQ(chunks_of(4, 1000).size(), 1u);
  EXPECT_TRUE(chunks_of(0, 4).empty());
}

TEST_F(Parallel, ASingleThreadIsOneForAsLongAsItLives) {
  set_num_threads(3);
  {
    const SingleThread single;
    EXPECT_EQ(num_threads(), 1);
  }
  EXPECT_EQ(num_threads(), 3);
}

TEST_F(Parallel, GrainZeroMeansOne) { EXPECT_EQ(chunks_of(5, 0).size(), 5u); }

TEST_F(Parallel, EachIndexOnce) {
  for (int threads : {1, 3}) {
    set_num_threads(threads);
    std::vector<std::atomic<int>> calls(1000);
    parallel_for_each(calls.size(), [&](size_t i) { ++calls[i]; });
    for (const std::atomic<int>& count : calls) ASSERT_EQ(count, 1);
  }
  parallel_for_each(0, [](size_t) { FAIL(); });
}

TEST_F(Parallel, SumsInChunkOrderAreTheSameForAnyNumberOfThreads) {
  const auto sum = [](int threads) {
    set_num_threads(threads);
    std::vector<double> partial(100);
    parallel_for_chunks(100000, 1000, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) partial[begin / 1000] += 1.0 / static_cast<double>(i + 1);
    });
    double total = 0.0;
    for (double p : partial) total += p;
    return total;
  };
  const double one = sum(1);
  EXPECT_NEAR(one, 12.090146129863428, 1e-12);  // the harmonic number of 100,000
  EXPECT_EQ(sum(2), one);
  EXPECT_EQ(sum(7), one);
}

TEST_F(Parallel, OneThreadStaysOnTheCaller) {
  set_num_threads(1);
  EXPECT_EQ(num_threads(), 1);
  const std::thread::id caller = std::this_thread::get_id();
  parallel_for_each(50, [&](size_t) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

TEST_F(Parallel, NumberOfThreads) {
  set_num_threads(3);
  EXPECT_EQ(num_threads(), 3);
  set_num_threads(0);
  EXPECT_EQ(num_threads(), static_cast<int>(std::thread::hardware_concurrency()));
}

TEST_F(Parallel, RethrowsExceptions) {
  EXPECT_THROW(parallel_for_each(10,
                                 [](size_t i) {
                                   if (i == 7) throw std::runtime_error("seven");
                                 }),
               std::runtime_error);
}

TEST_F(Parallel, RethrowsTheExceptionOfTheLeastIndexWhicheverComesFirst) {
  for (int threads : {1, 2, 4}) {
    set_num_threads(threads);
    std::vector<std::atomic<int>> calls(200);
    try {
      parallel_for_each(calls.size(), [&](size_t i) {
        ++calls[i];
        if (i < 30) return;
        // The first one is the slowest, so that others come before it.
        if (i == 30) std::this_thread::sleep_for(std::chrono::milliseconds(30));
        throw std::runtime_error(std::to_string(i));
      });
      FAIL() << threads << " threads";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "30") << threads << " threads";
    }
    for (size_t i = 0; i <= 30; ++i) EXPECT_EQ(calls[i], 1) << i;
  }
}

}  // namespace
}  // namespace cpplus
