#pragma once

#include <cstdint>

namespace cpplus {

/// A small seeded generator (SplitMix64) whose numbers are the same on every platform and standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t next();
  /// Uniform in [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform integer in [0, count).
  uint64_t below(uint64_t count);
  /// Standard normal (Box-Muller).
  double normal();

 private:
  uint64_t state_;
};

}  // namespace cpplus
