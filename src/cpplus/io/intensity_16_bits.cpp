#include "cpplus/io/intensity_16_bits.h"

#include <algorithm>
#include <cmath>

namespace cpplus {

double intensity_factor(std::span<const float> intensities) {
  bool any_fraction = false;
  for (const float intensity : intensities) {
    if (!(intensity >= 0.0f && intensity <= 1.0f)) return 1.0;
    any_fraction = any_fraction || (intensity > 0.0f && intensity < 1.0f);
  }
  return any_fraction ? 65535.0 : 1.0;
}

uint16_t to_16_bits(double value) {
  return static_cast<uint16_t>(std::isnan(value) ? 0.0 : std::clamp(std::round(value), 0.0, 65535.0));
}

}  // namespace cpplus
