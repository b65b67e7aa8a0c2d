#include "cpplus/visibility/hidden_ranges.h"

#include <algorithm>
#include <array>

namespace cpplus {
namespace {

// Edge of the blocks in cells, then in blocks of the level before.
constexpr std::array<int, 3> kBlockSizes = {8, 2, 2};
// A surface is some centimetres thick; the far side of an edge lies further behind.
constexpr float kMarginM = 0.5f;
// What a lens shows at the border of the image is larger than at its centre.
constexpr float kMagnification = 1.5f;

RangeImage farthest_of_blocks(const RangeImage& cells, int size) {
  RangeImage blocks((cells.width + size - 1) / size, (cells.height + size - 1) / size, 0.0f);
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      float& block = blocks.at(x / size, y / size);
      block = std::max(block, cells.at(x, y));
    }
  }
  return blocks;
}

RangeImage farthest_around(const RangeImage& blocks) {
  RangeImage around(blocks.width, blocks.height, 0.0f);
  for (int y = 0; y < blocks.height; ++y) {
    for (int x = 0; x < blocks.width; ++x) {
      for (int v = std::max(0, y - 1); v <= std::min(blocks.height - 1, y + 1); ++v) {
        for (int u = std::max(0, x - 1); u <= std::min(blocks.width - 1, x + 1); ++u) {
          around.at(x, y) = std::max(around.at(x, y), blocks.at(u, v));
        }
      }
    }
  }
  return around;
}

}  // namespace

HiddenRanges::HiddenRanges(const PlaneBuffer& planes) {
  if (planes.range_bound.empty()) return;
  pixels_per_radian_ = static_cast<float>(planes.camera.pixels_per_radian());
  RangeImage blocks = planes.range_bound;
  double block_px = planes.cell_px;
  for (const int size : kBlockSizes) {
    blocks = farthest_of_blocks(blocks, size);
    block_px *= size;
    levels_.push_back({static_cast<float>(block_px), farthest_around(blocks)});
  }
}

bool HiddenRanges::hides(const Eigen::Vector2f& pixel, float range_m, float radius_m) const {
  const float nearest_m = range_m - radius_m;
  const float radius_px = kMagnification * pixels_per_radian_ * radius_m / range_m;
  for (const auto& [block_px, farthest] : levels_) {
    if (radius_px > block_px) continue;
    const float x = (pixel.x() + 0.5f) / block_px;
    const float y = (pixel.y() + 0.5f) / block_px;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(farthest.width) && y < static_cast<float>(farthest.height))) {
      return false;
    }
    return nearest_m > farthest.at(static_cast<int>(x), static_cast<int>(y)) + kMarginM;
  }
  return false;
}

}  // namespace cpplus
