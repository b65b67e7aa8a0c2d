#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace cpplus {

/// Integer arithmetic of the voxel grid, shared by building and look-ups so that both round alike.
///
/// cell = floor(x_in_map / leaf_size_m) per axis. A voxel `shift` layers above the leaves has key cell >> shift. The
/// octant of a voxel in its parent is (x & 1) | (y & 1) << 1 | (z & 1) << 2.

/// Cells lie in (-max_cell, max_cell): keys of neighbours and differences of keys then fit in 32 bits.
inline constexpr int32_t max_cell = 1 << 30;
/// Largest root_size_m / leaf_size_m is 2^max_leaf_bits: Morton codes of leaves inside their root fit in 30 bits.
inline constexpr int max_leaf_bits = 10;

/// floor(scaled) in (-max_cell, max_cell), outside +-max_cell; not a number becomes -max_cell. (std::floor is a library
/// call on the x86-64 baseline.)
inline int32_t clamped_floor(double scaled) {
  if (!(std::abs(scaled) < max_cell)) [[unlikely]]
    return scaled > 0 ? max_cell : -max_cell;
  const int32_t truncated = static_cast<int32_t>(scaled);
  return truncated - static_cast<int32_t>(scaled < truncated);
}

/// Whether a coordinate was beyond the limit or not a number.
inline bool is_outside(const Eigen::Vector3i& cell) {
  const auto beyond = [](int32_t c) { return c <= -max_cell || c >= max_cell; };
  return beyond(cell.x()) || beyond(cell.y()) || beyond(cell.z());
}

/// How points become cells: everything that building and look-ups must round alike.
struct VoxelGrid {
  VoxelGrid() = default;
  VoxelGrid(const Eigen::Vector3d& cloud_origin, double root_size_m, double leaf_size_m)
      : origin(cloud_origin),
        leaves_per_m(1.0 / leaf_size_m),
        bits(static_cast<int>(std::lround(std::log2(root_size_m / leaf_size_m)))) {}

  Eigen::Vector3i cell_of_position(const Eigen::Vector3f& position) const {
    return cell_of(origin + position.cast<double>());
  }
  Eigen::Vector3i cell_of(const Eigen::Vector3d& x_in_map) const {
    const Eigen::Vector3d scaled = x_in_map * leaves_per_m;
    return {clamped_floor(scaled.x()), clamped_floor(scaled.y()), clamped_floor(scaled.z())};
  }

  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the cloud, metres
  double leaves_per_m = 0.0;
  int bits = 0;  // a root is 2^bits leaves wide
};

/// Cells of a block of points: VoxelGrid::cell_of_position in loops that the compiler turns into vector code.
class CellBlock {
 public:
  static constexpr size_t max_points = 256;

  explicit CellBlock(const VoxelGrid& grid);

  /// At most max_points positions. False where the cells of some are outside.
  bool compute(std::span<const Eigen::Vector3f> positions);
  Eigen::Vector3i cell(size_t i) const { return {cells_[3 * i], cells_[3 * i + 1], cells_[3 * i + 2]}; }

 private:
  static constexpr size_t max_coordinates = 3 * max_points;

  double leaves_per_m_;
  std::array<double, max_coordinates> origin_;  // x y z x y z ...
  std::array<double, max_coordinates> scaled_;
  std::array<int32_t, max_coordinates> cells_;
};

/// Bits of 0..1023 spread to every third bit.
inline constexpr std::array<uint32_t, 1 << max_leaf_bits> spread_bits = [] {
  std::array<uint32_t, 1 << max_leaf_bits> table{};
  for (uint32_t value = 0; value < table.size(); ++value) {
    for (int b = 0; b < max_leaf_bits; ++b) table[value] |= ((value >> b) & 1u) << (3 * b);
  }
  return table;
}();

/// Morton code of a cell inside its root; coordinates in [0, 2^max_leaf_bits).
inline uint32_t morton_code(uint32_t x, uint32_t y, uint32_t z) {
  return spread_bits[x] | spread_bits[y] << 1 | spread_bits[z] << 2;
}

inline int octant_of(const Eigen::Vector3i& key) { return (key.x() & 1) | (key.y() & 1) << 1 | (key.z() & 1) << 2; }

/// Shifts each coordinate, rounding towards minus infinity.
inline Eigen::Vector3i shift_down(const Eigen::Vector3i& key, int shift) {
  return {key.x() >> shift, key.y() >> shift, key.z() >> shift};
}

/// Order of the roots: by x, then y, then z.
inline bool key_less(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  if (a.x() != b.x()) return a.x() < b.x();
  if (a.y() != b.y()) return a.y() < b.y();
  return a.z() < b.z();
}

/// Multiplicative hashing: take the upper bits.
inline uint64_t hash_key(const Eigen::Vector3i& key) {
  return static_cast<uint64_t>(key.x()) * 0x9E3779B97F4A7C15ull +
         static_cast<uint64_t>(key.y()) * 0xC2B2AE3D27D4EB4Full +
         static_cast<uint64_t>(key.z()) * 0xD6E8FEB86659FD93ull;
}

inline constexpr uint32_t no_voxel = 0xFFFFFFFFu;

/// Number of set bits among the lowest 0..8; a table because the x86-64 baseline has no such instruction.
inline constexpr std::array<uint8_t, 256> bit_counts = [] {
  std::array<uint8_t, 256> table{};
  for (size_t mask = 1; mask < table.size(); ++mask) table[mask] = static_cast<uint8_t>(table[mask / 2] + mask % 2);
  return table;
}();

/// Slot of a key in an open-addressing table of indices into `keys`: the one that holds it, or the empty one (value
/// no_voxel) where it belongs. The table's size is a power of two and larger than the number of keys.
inline size_t probe_key_table(std::span<const uint32_t> table, std::span<const Eigen::Vector3i> keys,
                              const Eigen::Vector3i& key) {
  const size_t mask = table.size() - 1;
  size_t slot = hash_key(key) >> (64 - std::countr_zero(table.size()));
  while (table[slot] != no_voxel && keys[table[slot]] != key) slot = (slot + 1) & mask;
  return slot;
}

/// A table for `keys` (all different) of more than min_size slots.
inline std::vector<uint32_t> make_key_table(std::span<const Eigen::Vector3i> keys, size_t min_size) {
  std::vector<uint32_t> table(std::bit_ceil(std::max<size_t>(min_size, 1) + 1), no_voxel);
  for (size_t i = 0; i < keys.size(); ++i) table[probe_key_table(table, keys, keys[i])] = static_cast<uint32_t>(i);
  return table;
}

/// The table of a voxel map's roots.
inline std::vector<uint32_t> make_root_table(std::span<const Eigen::Vector3i> root_keys) {
  return make_key_table(root_keys, 3 * root_keys.size() / 2);
}

}  // namespace cpplus
