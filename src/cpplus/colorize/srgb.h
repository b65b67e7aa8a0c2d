#pragma once

#include <cstdint>

namespace cpplus {

/// Light, 0 to 1, that a grey level of an image stands for by the sRGB curve (IEC 61966-2-1):
///   v <= 0.04045: v / 12.92; above: ((v + 0.055) / 1.055)^2.4, with v = level / 255.
/// Factors of exposure multiply light, not grey levels.
float light_of_level(uint8_t level);

/// The grey level, not rounded, of an amount of light; light outside [0, 1] is clamped. Within 0.15 levels of the
/// curve.
float level_of_light(float light);

}  // namespace cpplus
