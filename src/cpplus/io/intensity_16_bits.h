#pragma once

#include <cstdint>
#include <span>

namespace cpplus {

/// What intensities are multiplied by to fill 16 bits: 65535 where they are fractions (all within 0 and 1, not only 0
/// and 1 themselves), else 1, since files hold them in units of their own.
class IntensityFactor {
 public:
  void add(std::span<const float> some);
  /// Of all that were added.
  double value() const { return all_are_shares_ && any_fraction_ ? 65535.0 : 1.0; }

 private:
  bool all_are_shares_ = true;
  bool any_fraction_ = false;
};

/// Rounded, and cut off at the ends; 0 for not a number.
uint16_t to_16_bits(double value);

}  // namespace cpplus
