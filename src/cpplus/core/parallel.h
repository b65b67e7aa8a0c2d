#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace cpplus {

/// Sets how many threads parallel_for may use from now on; 0 means all cores.
void set_num_threads(int num_threads);
int num_threads();

/// While one lives, what the process does in TBB's threads is done by one: for libraries whose results depend on it.
class SingleThread {
 public:
  SingleThread();
  ~SingleThread();
  SingleThread(const SingleThread&) = delete;
  SingleThread& operator=(const SingleThread&) = delete;

 private:
  struct Limit;
  std::unique_ptr<Limit> limit_;
};

/// Calls body(begin, end) for consecutive chunks of [0, size) of at most `grain` elements. The chunk borders depend
/// only on size and grain, never on the number of threads: a result kept per chunk and combined in chunk order is
/// the same for any number of threads. Of the exceptions from bodies that of the first chunk is rethrown here.
void parallel_for_chunks(size_t size, size_t grain, const std::function<void(size_t begin, size_t end)>& body);

/// Calls body(i) for each i in [0, size), one task an index: for few, heavy items. Where bodies throw, the exception of
/// the least such i is rethrown, whatever the number of threads; larger ones may be left out. Throws Interrupted in
/// place of the next call once a stop was asked for (core/interrupt.h).
void parallel_for_each(size_t size, const std::function<void(size_t i)>& body);

}  // namespace cpplus
