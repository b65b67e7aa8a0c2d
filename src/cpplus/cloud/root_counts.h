#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map_grid.h"
#include "cpplus/core/memory.h"

namespace cpplus {

/// The roots that points fall in, in the order of meeting them, and how many points fall in each.
class RootCounts {
 public:
  /// Index of the root of `key` here; counts `count` points.
  uint32_t add(const Eigen::Vector3i& key, uint32_t count) {
    const size_t slot = slot_of(key);
    uint32_t root = slots_[slot].root;
    if (root == no_voxel) [[unlikely]]
      root = insert(key, slot);
    counts[root] += count;
    return root;
  }

  /// Index of the root of `key`; no_voxel where it is not here.
  uint32_t find(const Eigen::Vector3i& key) const { return slots_[slot_of(key)].root; }

  /// Forgets all roots and keeps the memory.
  void clear() {
    keys.clear();
    counts.clear();
    std::fill(slots_.begin(), slots_.end(), Slot());
  }

  /// Frees what add() needs, which takes more memory than the counts; no root can be added any more.
  void finish() { free_memory(&slots_); }

  std::vector<Eigen::Vector3i> keys;
  std::vector<uint32_t> counts;

 private:
  struct Slot {
    int32_t x = 0, y = 0, z = 0;
    uint32_t root = no_voxel;

    bool holds(const Eigen::Vector3i& key) const { return ((x ^ key.x()) | (y ^ key.y()) | (z ^ key.z())) == 0; }
  };

  /// The slot that holds the key, or the empty one where it belongs. The table is sparse and has the keys inside:
  /// nearly every look-up ends at the first slot, which the processor predicts.
  size_t slot_of(const Eigen::Vector3i& key) const {
    size_t slot = hash_key(key) >> shift_;
    while (slots_[slot].root != no_voxel && !slots_[slot].holds(key)) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }

  uint32_t insert(const Eigen::Vector3i& key, size_t slot);
  void grow();

  std::vector<Slot> slots_ = std::vector<Slot>(1024);
  int shift_ = 64 - 10;  // leaves as many bits of the hash as slots_ has slots
};

/// Counts the points of each root and writes the index of each point's root in `roots`, no_voxel for a point that is
/// not finite. Stops at the first finite point beyond the limit of the grid and returns its place.
std::optional<size_t> count_roots(std::span<const Eigen::Vector3f> positions, const VoxelGrid& grid, RootCounts* roots,
                                  uint32_t* roots_of_points);

/// "point 7 at (...) m is outside the voxel grid: ..."
std::string beyond_grid_message(size_t point, const Eigen::Vector3d& x_in_map, double leaf_size_m);

}  // namespace cpplus
