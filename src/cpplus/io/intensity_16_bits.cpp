#include "cpplus/io/intensity_16_bits.h"

#include <algorithm>
#include <cmath>

namespace cpplus {

void IntensityFactor::add(std::span<const float> some) {
  for (const float intensity : some) {
    all_are_shares_ = all_are_shares_ && intensity >= 0.0f && intensity <= 1.0f;
    any_fraction_ = any_fraction_ || (intensity > 0.0f && intensity < 1.0f);
  }
}

uint16_t to_16_bits(double value) {
  return static_cast<uint16_t>(std::isnan(value) ? 0.0 : std::clamp(std::round(value), 0.0, 65535.0));
}

}  // namespace cpplus
