#include "cpplus/visibility/hidden_ranges.h"

#include <algorithm>
#include <limits>

namespace cpplus {
namespace {

constexpr int kBlockCells = 8;
// A surface is some centimetres thick, a leaf as large; the far side of an edge lies further behind.
constexpr float kMarginM = 0.5f;
// A nearer leaf may reach beyond the blocks around its point.
constexpr float kMinRangeM = 1.5f;

RangeImage farthest_of_blocks(const RangeImage& cells) {
  RangeImage blocks((cells.width + kBlockCells - 1) / kBlockCells, (cells.height + kBlockCells - 1) / kBlockCells,
                    0.0f);
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      float& block = blocks.at(x / kBlockCells, y / kBlockCells);
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

HiddenRanges::HiddenRanges(const PlaneBuffer& planes)
    : block_px_(static_cast<float>(kBlockCells * planes.cell_px)),
      farthest_(farthest_around(farthest_of_blocks(planes.range_bound))) {}

bool HiddenRanges::hides(const Eigen::Vector2f& pixel, float range_m) const {
  if (range_m < kMinRangeM) return false;
  const float x = (pixel.x() + 0.5f) / block_px_;
  const float y = (pixel.y() + 0.5f) / block_px_;
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(farthest_.width) && y < static_cast<float>(farthest_.height))) {
    return false;
  }
  return range_m > farthest_.at(static_cast<int>(x), static_cast<int>(y)) + kMarginM;
}

}  // namespace cpplus
