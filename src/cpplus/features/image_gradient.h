#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// Gradient of a blurred grey image in fixed point: 16 bits are enough for 1/128 grey level per pixel. (Rounding the
/// blurred image to whole grey levels would double the position error of weak edges.)
struct ImageGradient {
  static constexpr float kUnitsPerLevel = 128.0f;

  int width = 0;
  int height = 0;
  std::vector<int16_t> dx;  // row-major, kUnitsPerLevel * grey levels per pixel, towards larger columns
  std::vector<int16_t> dy;

  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
};

/// Gaussian blur of sigma_px, then Sobel's 3x3 differences; the border is reflected. The image must not be empty.
ImageGradient blurred_gradient(const GrayImage& image, double sigma_px);

}  // namespace cpplus
