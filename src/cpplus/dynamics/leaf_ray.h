#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Casts rays from one position through the non-empty leaves of a voxel map. A ray leaves an empty voxel of any layer
/// in one step, and comes down again only from the lowest voxel that holds both the cell it left and the cell it
/// enters. The map must outlive it.
class LeafRayCaster {
 public:
  /// The box of roots around the origin stays below 257^3 with this.
  static constexpr double max_radius_roots = 128.0;

  /// Rays end at the latest where they leave the roots within radius_m (metres) of the origin. Keeps 4 bytes for every
  /// root, empty or not, of the box around these roots.
  LeafRayCaster(const VoxelMap& map, const Eigen::Vector3d& origin_in_map, double radius_m);

  /// Calls visit(leaf) for the non-empty leaves that the ray meets before `distance_m`, nearest first. The direction
  /// has unit length.
  template <typename Visit>
  void cast(const Eigen::Vector3d& direction_in_map, double distance_m, const Visit& visit) const;

 private:
  static constexpr int max_layers = max_leaf_bits + 1;

  /// The way down from a root to the lowest voxel that holds a cell.
  struct Descent {
    std::array<uint32_t, max_layers> nodes{};
    int layer = -1;  // of the lowest voxel that exists, -1: the root is empty
  };

  uint32_t root_of(const Eigen::Vector3i& cell) const {
    const Eigen::Vector3i root = shift_down(cell, leaf_layer_);
    return roots_[static_cast<size_t>((root.z() * size_.y() + root.y()) * size_.x() + root.x())];
  }
  bool is_inside(const Eigen::Vector3i& cell) const {
    const auto inside = [&](int axis) { return cell[axis] >= 0 && cell[axis] >> leaf_layer_ < size_[axis]; };
    return inside(0) && inside(1) && inside(2);
  }
  /// Goes down from nodes[layer], or from the root for layer -1.
  void go_down(int layer, const Eigen::Vector3i& cell, Descent* descent) const;

  const VoxelMap& map_;
  int leaf_layer_;
  Eigen::Vector3i low_;               // root key of the box's corner: cells count from there
  Eigen::Vector3i size_;              // of the box, roots
  Eigen::Vector3d origin_in_leaves_;  // from the box's corner
  std::vector<uint32_t> roots_;
};

inline void LeafRayCaster::go_down(int layer, const Eigen::Vector3i& cell, Descent* descent) const {
  if (layer < 0) {
    descent->nodes[0] = root_of(cell);
    if (descent->nodes[0] == no_voxel) {
      descent->layer = -1;
      return;
    }
    layer = 0;
  }
  for (; layer < leaf_layer_; ++layer) {
    const int octant = octant_of(shift_down(cell, leaf_layer_ - layer - 1));
    const uint32_t child = map_.child_in_octant(layer, descent->nodes[static_cast<size_t>(layer)], octant);
    if (child == no_voxel) break;
    descent->nodes[static_cast<size_t>(layer) + 1] = child;
  }
  descent->layer = layer;
}

template <typename Visit>
void LeafRayCaster::cast(const Eigen::Vector3d& direction_in_map, double distance_m, const Visit& visit) const {
  const double end = distance_m / map_.options().leaf_size_m;  // leaves, as everything below
  const Eigen::Vector3d inverse = direction_in_map.cwiseInverse();
  const Eigen::Vector3i last_cell = size_ * (1 << leaf_layer_) - Eigen::Vector3i::Ones();
  Eigen::Vector3i cell = origin_in_leaves_.cast<int>().cwiseMin(last_cell);
  Descent descent;
  go_down(-1, cell, &descent);
  for (double entry = 0.0; entry < end;) {
    const bool is_leaf = descent.layer == leaf_layer_;
    if (is_leaf) visit(descent.nodes[static_cast<size_t>(leaf_layer_)]);
    // The voxel to leave: the leaf, or the empty one below the lowest that exists.
    const int bits = is_leaf ? 0 : leaf_layer_ - descent.layer - 1;
    const Eigen::Vector3i low = shift_down(cell, bits) * (1 << bits);
    const int last = (1 << bits) - 1;
    int axis = 0;
    double exit = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
      if (direction_in_map[a] == 0.0) continue;
      const int border = direction_in_map[a] > 0.0 ? low[a] + last + 1 : low[a];
      const double crossing = (border - origin_in_leaves_[a]) * inverse[a];
      if (crossing < exit) {
        exit = crossing;
        axis = a;
      }
    }
    if (!(exit < end)) return;
    Eigen::Vector3i next;
    for (int a = 0; a < 3; ++a) {
      // Rounding must not take the ray out of the voxel through a side that it does not cross.
      const int at_exit = static_cast<int>(origin_in_leaves_[a] + exit * direction_in_map[a]);
      next[a] = std::clamp(at_exit, low[a], low[a] + last);
    }
    next[axis] = direction_in_map[axis] > 0.0 ? low[axis] + last + 1 : low[axis] - 1;
    if (!is_inside(next)) return;
    const Eigen::Vector3i changed(cell.x() ^ next.x(), cell.y() ^ next.y(), cell.z() ^ next.z());
    const int changed_bits = std::bit_width(static_cast<uint32_t>(changed.x() | changed.y() | changed.z()));
    cell = next;
    entry = exit;
    go_down(leaf_layer_ - changed_bits, cell, &descent);
  }
}

}  // namespace cpplus
