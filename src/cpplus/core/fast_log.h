#pragma once

#include <bit>
#include <cstdint>

namespace cpplus {

/// log2 of positive, normal numbers to 2e-5; without branches, so that loops over it become vector instructions.
/// log2(1 + u) = u + u (1 - u) q(u) for u in [0, 1), q fitted.
inline float fast_log2(float value) {
  const auto bits = std::bit_cast<int32_t>(value);
  const float u = std::bit_cast<float>((bits & 0x007fffff) | 0x3f800000) - 1.0f;
  const float q = 0.44191667f + u * (-0.2671764f + u * (0.14841999f - u * 0.04514474f));
  return static_cast<float>((bits >> 23) - 127) + u + u * (1.0f - u) * q;
}

}  // namespace cpplus
