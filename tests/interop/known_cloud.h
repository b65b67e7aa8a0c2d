#pragma once

#include <array>
#include <cstdint>

/// The points that the programs of other libraries write and the test expects: exact in float32 and in short ASCII.
namespace interop {

inline std::array<float, 3> position(int i) {
  return {0.125f * static_cast<float>(i), -0.25f * static_cast<float>(i), 0.5f * static_cast<float>(i % 7)};
}
inline float intensity(int i) { return static_cast<float>(i % 256); }
inline std::array<uint8_t, 3> color(int i) {
  return {static_cast<uint8_t>(i), static_cast<uint8_t>(3 * i), static_cast<uint8_t>(255 - i % 256)};
}

}  // namespace interop
