#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cpplus {

using Rgb = std::array<uint8_t, 3>;

/// A row-major image. The centre of the top-left pixel is (0, 0); x = column, y = row.
template <typename Pixel>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Pixel> pixels;  // size width * height

  Image() = default;
  Image(int image_width, int image_height, Pixel value = Pixel{})
      : width(image_width),
        height(image_height),
        pixels(static_cast<size_t>(image_width) * static_cast<size_t>(image_height), value) {}

  bool empty() const { return pixels.empty(); }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  Pixel& at(int x, int y) { return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)]; }
  const Pixel& at(int x, int y) const {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

using GrayImage = Image<uint8_t>;
using ColorImage = Image<Rgb>;
/// Distance from the camera centre along the viewing ray ("range"), metres; 0 = nothing there.
using RangeImage = Image<float>;

}  // namespace cpplus
