#pragma once

#include <Eigen/Core>
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

/// Cells must lie in (-max_cell, max_cell): keys of neighbours and differences of keys then fit in 32 bits.
inline constexpr int32_t max_cell = 1 << 30;
/// Largest root_size_m / leaf_size_m is 2^max_leaf_bits: Morton codes of leaves inside their root fit in 30 bits.
inline constexpr int max_leaf_bits = 10;

/// floor() for |value| < 2^31. std::floor is a library call on the x86-64 baseline.
inline int32_t floor_to_cell(double value) {
  const int32_t truncated = static_cast<int32_t>(value);
  return truncated - static_cast<int32_t>(value < truncated);
}

/// How points become cells: everything that building and look-ups must round alike.
struct VoxelGrid {
  VoxelGrid() = default;
  VoxelGrid(const Eigen::Vector3d& cloud_origin, double root_size_m, double leaf_size_m)
      : origin(cloud_origin),
        leaves_per_m(1.0 / leaf_size_m),
        bits(static_cast<int>(std::lround(std::log2(root_size_m / leaf_size_m)))) {}

  /// Position in units of leaves, not rounded.
  Eigen::Vector3d scaled(const Eigen::Vector3f& position) const {
    return (origin + position.cast<double>()) * leaves_per_m;
  }
  static bool within_limits(const Eigen::Vector3d& scaled) {
    return std::abs(scaled.x()) < max_cell && std::abs(scaled.y()) < max_cell && std::abs(scaled.z()) < max_cell;
  }
  static Eigen::Vector3i cell_of(const Eigen::Vector3d& scaled) {
    return {floor_to_cell(scaled.x()), floor_to_cell(scaled.y()), floor_to_cell(scaled.z())};
  }

  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the cloud, metres
  double leaves_per_m = 0.0;
  int bits = 0;  // a root is 2^bits leaves wide
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

inline uint64_t hash_key(const Eigen::Vector3i& key) {
  uint64_t h = static_cast<uint32_t>(key.x()) * 0x9E3779B97F4A7C15ull;
  h ^= static_cast<uint32_t>(key.y()) * 0xC2B2AE3D27D4EB4Full;
  h ^= static_cast<uint32_t>(key.z()) * 0x165667B19E3779F9ull;
  return (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ull >> 32;
}

inline constexpr uint32_t no_voxel = 0xFFFFFFFFu;

/// Slot of a key in an open-addressing table of indices into `keys`: the one that holds it, or the empty one (value
/// no_voxel) where it belongs. The table's size is a power of two and larger than the number of keys.
inline size_t probe_key_table(std::span<const uint32_t> table, std::span<const Eigen::Vector3i> keys,
                              const Eigen::Vector3i& key) {
  const size_t mask = table.size() - 1;
  size_t slot = hash_key(key) & mask;
  while (table[slot] != no_voxel && keys[table[slot]] != key) slot = (slot + 1) & mask;
  return slot;
}

/// A table for `keys` (all different) of more than min_size slots.
inline std::vector<uint32_t> make_key_table(std::span<const Eigen::Vector3i> keys, size_t min_size) {
  std::vector<uint32_t> table(std::bit_ceil(min_size + 1), no_voxel);
  for (size_t i = 0; i < keys.size(); ++i) table[probe_key_table(table, keys, keys[i])] = static_cast<uint32_t>(i);
  return table;
}

}  // namespace cpplus
