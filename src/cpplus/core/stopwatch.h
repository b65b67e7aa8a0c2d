#pragma once

#include <chrono>

namespace cpplus {

/// Wall-clock time since its construction or the last lap.
class Stopwatch {
 public:
  double milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  /// The time so far, and starts again.
  double lap() {
    const double elapsed = milliseconds();
    start_ = std::chrono::steady_clock::now();
    return elapsed;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace cpplus
