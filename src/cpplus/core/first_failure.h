#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>

namespace cpplus {

/// The exception of the least index that throws. Indices above it need not be run any more, those below it must be, so
/// that it is the same one whatever thread comes first.
class FirstFailure {
 public:
  explicit FirstFailure(size_t none) : index_(none) {}

  size_t index() const { return index_.load(std::memory_order_relaxed); }

  /// Takes the exception that is being handled.
  void add(size_t index) {
    const std::lock_guard lock(mutex_);
    if (index >= index_.load()) return;
    index_ = index;
    exception_ = std::current_exception();
  }

  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::atomic<size_t> index_;
  std::mutex mutex_;
  std::exception_ptr exception_;
};

}  // namespace cpplus
