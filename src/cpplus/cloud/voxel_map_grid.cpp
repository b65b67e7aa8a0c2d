#include "cpplus/cloud/voxel_map_grid.h"

namespace cpplus {

CellBlock::CellBlock(const VoxelGrid& grid) : leaves_per_m_(grid.leaves_per_m) {
  for (size_t i = 0; i < max_coordinates; ++i) origin_[i] = grid.origin[static_cast<int>(i % 3)];
}

bool CellBlock::compute(std::span<const Eigen::Vector3f> positions) {
  const float* position = positions.data()->data();
  const size_t size = 3 * positions.size();
  for (size_t i = 0; i < size; ++i) {
    scaled_[i] = (origin_[i] + static_cast<double>(position[i])) * leaves_per_m_;
  }
  // Comparisons of doubles would keep the compiler from using vectors; comparing their bits does not. The magnitudes
  // of doubles are in the order of their bits, and those of what is not finite come last.
  constexpr uint64_t limit = std::bit_cast<uint64_t>(static_cast<double>(max_cell));
  uint64_t outside = 0;
  for (size_t i = 0; i < size; ++i) {
    outside |= limit - 1 - (std::bit_cast<uint64_t>(scaled_[i]) & ~(uint64_t{1} << 63));
  }
  if (outside >> 63 != 0) {
    for (size_t i = 0; i < size; ++i) cells_[i] = clamped_floor(scaled_[i]);
    return false;
  }
  for (size_t i = 0; i < size; ++i) cells_[i] = static_cast<int32_t>(scaled_[i]);
  // Truncated upwards where the rest is negative; adding zero makes a positive zero of a negative one.
  for (size_t i = 0; i < size; ++i) scaled_[i] = (scaled_[i] - static_cast<double>(cells_[i])) + 0.0;
  for (size_t i = 0; i < size; ++i) cells_[i] -= static_cast<int32_t>(std::bit_cast<uint64_t>(scaled_[i]) >> 63);
  return true;
}

}  // namespace cpplus
