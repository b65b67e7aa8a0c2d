#pragma once

#include <cstdint>

namespace cpplus {

/// Mixes two numbers into a seed: each pixel, beam and texture cell gets a random stream of its own, so that nothing
/// depends on the order in which threads reach them.
inline uint64_t hash_seed(uint64_t a, uint64_t b) {
  uint64_t z = a * 0x9E3779B97F4A7C15ull + b + 0x632BE59BD9B4E019ull;
  z = (z ^ (z >> 32)) * 0xD6E8FEB86659FD93ull;
  z = (z ^ (z >> 29)) * 0xBF58476D1CE4E5B9ull;
  return z ^ (z >> 32);
}

inline uint64_t hash_seed(uint64_t a, uint64_t b, uint64_t c) { return hash_seed(hash_seed(a, b), c); }

/// Uniform in [0, 1).
inline float hash_uniform(uint64_t hash) { return static_cast<float>(hash >> 40) * 0x1.0p-24f; }

}  // namespace cpplus
