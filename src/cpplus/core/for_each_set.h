#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace cpplus {

/// Calls visit(i) for the bytes that are not 0, ascending. Where most are 0 they are passed over eight at a time. A
/// visit may change its own byte and later ones from the next eight on.
template <typename Visit>
void for_each_set(const uint8_t* bytes, size_t count, const Visit& visit) {
  for (size_t begin = 0; begin < count; begin += 8) {
    uint64_t eight = 0;
    if (begin + 8 <= count) {
      for (size_t i = 0; i < 8; ++i) eight |= uint64_t{bytes[begin + i]} << (8 * i);
    } else {
      for (size_t i = 0; begin + i < count; ++i) eight |= uint64_t{bytes[begin + i]} << (8 * i);
    }
    while (eight != 0) {
      const int i = std::countr_zero(eight) / 8;
      eight &= ~(uint64_t{0xff} << (8 * i));
      visit(begin + static_cast<size_t>(i));
    }
  }
}

}  // namespace cpplus
