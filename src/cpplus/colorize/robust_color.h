#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cpplus/core/image.h"

namespace cpplus {

/// A colour in grey levels, not rounded, after its image's exposure has been divided out.
struct WeightedColor {
  std::array<float, 3> color{};
  float weight = 0.0f;
};

struct RobustColor {
  Rgb color{};
  size_t best = 0;     // index of the heaviest sample that agrees with the colour
  uint8_t spread = 0;  // RMS difference of all samples (weighted, all channels) from the colour, grey levels
};

/// The colour that most samples stand for. Each sample counts the votes of those within max_deviation grey levels of it
/// in all channels, a vote being the square root of a weight: so one heavy sample loses against two of a fourth of its
/// weight or more that agree with each other, and of two samples that contradict each other the heavier wins (the
/// earlier one where they are equally heavy) rather than a mixture that no image shows. The colour is the weighted mean
/// of those within max_deviation of the winners' mean. All zero without samples.
RobustColor robust_color(std::span<const WeightedColor> samples, double max_deviation);

}  // namespace cpplus
