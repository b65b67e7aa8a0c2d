#include "cpplus/colorize/gray_scale.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace cpplus {
namespace {

constexpr uint8_t kMidGray = 128;
constexpr double kBrightestGray = 160.0;
constexpr double kBrightestShare = 0.99;

/// Numbers in the order of the floats.
uint32_t order_of(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}
float value_of(uint32_t order) {
  return std::bit_cast<float>((order & 0x80000000u) != 0 ? order & 0x7FFFFFFFu : ~order);
}

/// Value of the given rank among those that are finite and whose upper half is `upper` (all for nothing), by one digit
/// of 16 bits. Returns the digit, and takes the values below it off the rank.
uint32_t digit_at(std::span<const float> values, std::optional<uint32_t> upper, size_t* rank) {
  std::vector<size_t> counts(1 << 16, 0);
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    const uint32_t order = order_of(value);
    if (!upper) {
      ++counts[order >> 16];
    } else if (order >> 16 == *upper) {
      ++counts[order & 0xFFFF];
    }
  }
  uint32_t digit = 0;
  for (; *rank >= counts[digit]; ++digit) *rank -= counts[digit];
  return digit;
}

}  // namespace

GrayScale::GrayScale(std::span<const float> intensities) {
  const auto num_finite = static_cast<size_t>(
      std::count_if(intensities.begin(), intensities.end(), [](float value) { return std::isfinite(value); }));
  if (num_finite == 0) return;
  auto rank = static_cast<size_t>(kBrightestShare * static_cast<double>(num_finite - 1));
  const uint32_t upper = digit_at(intensities, std::nullopt, &rank);
  const uint32_t lower = digit_at(intensities, upper, &rank);
  const float percentile = value_of(upper << 16 | lower);
  if (percentile > 0.0f) brightest_ = percentile;
}

Rgb GrayScale::gray(float intensity) const {
  if (!brightest_ || !std::isfinite(intensity)) return gray();
  const auto level = static_cast<uint8_t>(std::lround(kBrightestGray * std::clamp(intensity / *brightest_, 0.0, 1.0)));
  return {level, level, level};
}

Rgb GrayScale::gray() const { return {kMidGray, kMidGray, kMidGray}; }

}  // namespace cpplus
