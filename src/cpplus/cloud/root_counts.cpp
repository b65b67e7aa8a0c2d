#include "cpplus/cloud/root_counts.h"

#include <fmt/format.h>

#include <algorithm>

namespace cpplus {
namespace {

/// Slots a root: many while that takes little memory, since look-ups then need no second slot.
size_t min_slots(size_t num_roots) {
  constexpr size_t kMany = size_t{1} << 15;
  return num_roots <= kMany ? 8 * num_roots : 2 * num_roots;
}

}  // namespace

uint32_t RootCounts::insert(const Eigen::Vector3i& key, size_t slot) {
  const uint32_t root = static_cast<uint32_t>(keys.size());
  slots_[slot] = {key.x(), key.y(), key.z(), root};
  keys.push_back(key);
  counts.push_back(0);
  if (min_slots(keys.size()) > slots_.size()) grow();
  return root;
}

void RootCounts::grow() {
  const int bits = slots_.size() < (size_t{1} << 18) ? 2 : 1;
  slots_.assign(slots_.size() << bits, Slot());
  shift_ -= bits;
  for (uint32_t root = 0; root < keys.size(); ++root) {
    size_t slot = hash_key(keys[root]) >> shift_;
    while (slots_[slot].root != no_voxel) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = {keys[root].x(), keys[root].y(), keys[root].z(), root};
  }
}

std::optional<size_t> count_roots(std::span<const Eigen::Vector3f> positions, const VoxelGrid& grid, RootCounts* roots,
                                  uint32_t* roots_of_points) {
  CellBlock block(grid);
  for (size_t first = 0; first < positions.size(); first += CellBlock::max_points) {
    const size_t size = std::min(CellBlock::max_points, positions.size() - first);
    const bool all_inside = block.compute(positions.subspan(first, size));
    for (size_t i = first; i < first + size; ++i) {
      const Eigen::Vector3i cell = block.cell(i - first);
      if (all_inside || !is_outside(cell)) {
        roots_of_points[i] = roots->add(shift_down(cell, grid.bits), 1);
        continue;
      }
      roots_of_points[i] = no_voxel;
      if (positions[i].allFinite()) return i;
    }
  }
  return std::nullopt;
}

std::string beyond_grid_message(size_t point, const Eigen::Vector3d& x_in_map, double leaf_size_m) {
  return fmt::format(
      "point {} at ({}, {}, {}) m is outside the voxel grid: with leaf_size_m {} coordinates must be within +-{} m",
      point, x_in_map.x(), x_in_map.y(), x_in_map.z(), leaf_size_m, max_cell * leaf_size_m);
}

}  // namespace cpplus
