#pragma once

#include <cstdint>
#include <span>

namespace cpplus {

/// What intensities are multiplied by to fill 16 bits: 65535 where they are fractions (all within 0 and 1, not only 0
/// and 1 themselves), else 1, since files hold them in units of their own.
double intensity_factor(std::span<const float> intensities);

/// Rounded, and cut off at the ends; 0 for not a number.
uint16_t to_16_bits(double value);

}  // namespace cpplus
