#include "cpplus/core/nth_smallest.h"

#include <array>
#include <bit>
#include <cassert>
#include <cstdint>

namespace cpplus {
namespace {

constexpr int kDigitBits = 11;
constexpr size_t kDigits = size_t{1} << kDigitBits;

}  // namespace

float nth_smallest(std::span<const float> values, size_t rank) {
  assert(rank < values.size());
  uint32_t found = 0;  // the upper bits of the value
  uint32_t known = 0;  // a mask of these
  for (int shift = 32 - kDigitBits; known != ~uint32_t{0}; shift = shift > kDigitBits ? shift - kDigitBits : 0) {
    std::array<uint32_t, kDigits> counts{};
    for (const float value : values) {
      const auto bits = std::bit_cast<uint32_t>(value);
      if ((bits & known) == found) ++counts[bits >> shift & (kDigits - 1)];
    }
    size_t digit = 0;
    while (rank >= counts[digit]) rank -= counts[digit++];
    found |= static_cast<uint32_t>(digit) << shift;
    known |= static_cast<uint32_t>(kDigits - 1) << shift;
  }
  return std::bit_cast<float>(found);
}

}  // namespace cpplus
