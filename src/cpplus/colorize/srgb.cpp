#include "cpplus/colorize/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace cpplus {
namespace {

constexpr size_t kNumSteps = 16384;

std::array<float, 256> make_light_table() {
  std::array<float, 256> table{};
  for (size_t level = 0; level < table.size(); ++level) {
    const double v = static_cast<double>(level) / 255.0;
    table[level] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return table;
}

std::array<float, kNumSteps + 1> make_level_table() {
  std::array<float, kNumSteps + 1> table{};
  for (size_t i = 0; i < table.size(); ++i) {
    const double light = static_cast<double>(i) / kNumSteps;
    table[i] =
        static_cast<float>(255.0 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055));
  }
  return table;
}

}  // namespace

float light_of_level(uint8_t level) {
  static const std::array<float, 256> table = make_light_table();
  return table[level];
}

float level_of_light(float light) {
  static const std::array<float, kNumSteps + 1> table = make_level_table();
  return table[static_cast<size_t>(std::clamp(light, 0.0f, 1.0f) * kNumSteps + 0.5f)];
}

}  // namespace cpplus
