#include "cpplus/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <thread>

#include "cpplus/core/first_failure.h"
#include "cpplus/core/interrupt.h"

namespace cpplus {
namespace {

std::unique_ptr<tbb::global_control>& thread_limit() {
  static std::unique_ptr<tbb::global_control> limit;
  return limit;
}

}  // namespace

void set_num_threads(int num_threads) {
  const size_t count = num_threads > 0 ? static_cast<size_t>(num_threads) : std::thread::hardware_concurrency();
  thread_limit().reset();
  thread_limit() =
      std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, std::max<size_t>(1, count));
}

int num_threads() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

struct SingleThread::Limit {
  tbb::global_control control{tbb::global_control::max_allowed_parallelism, 1};
};

SingleThread::SingleThread() : limit_(std::make_unique<Limit>()) {}
SingleThread::~SingleThread() = default;

void parallel_for_chunks(size_t size, size_t grain, const std::function<void(size_t, size_t)>& body) {
  if (size == 0) return;
  grain = std::max<size_t>(1, grain);
  const size_t num_chunks = (size + grain - 1) / grain;
  parallel_for_each(num_chunks, [&](size_t chunk) { body(chunk * grain, std::min(size, (chunk + 1) * grain)); });
}

void parallel_for_each(size_t size, const std::function<void(size_t)>& body) {
  FirstFailure failure(size);
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, size, 1),
      [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i != range.end() && i < failure.index(); ++i) {
          try {
            check_interrupt();
            body(i);
          } catch (...) {
            failure.add(i);
          }
        }
      },
      tbb::simple_partitioner());
  failure.rethrow();
}

}  // namespace cpplus
