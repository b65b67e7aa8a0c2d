#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
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

  /// One coordinate of a ray. Which side it leaves a voxel by cannot be predicted: these select, they do not branch.
  struct Axis {
    Axis(double origin_in_leaves, double component)
        : origin(origin_in_leaves), direction(component), inverse(component == 0.0 ? parallel : 1.0 / component) {}

    /// Where the ray leaves a voxel's low or high side.
    double exit(int low, int size) const { return (low + (direction >= 0.0 ? size : 0) - origin) * inverse; }
    /// The cell that it enters: beyond that side, or where it is inside the voxel's width, whatever the rounding.
    int next(bool leaves_here, double exit, int low, int size) const {
      const int beyond = direction >= 0.0 ? low + size : low - 1;
      const int inside = std::clamp(static_cast<int>(origin + exit * direction), low, low + size - 1);
      return leaves_here ? beyond : inside;
    }

    static constexpr double parallel = 1e300;  // it leaves by another side before
    double origin;
    double direction;
    double inverse;
  };

  uint32_t root_of(const Eigen::Vector3i& cell) const {
    const Eigen::Vector3i root = shift_down(cell, leaf_layer_);
    return roots_[static_cast<size_t>((root.z() * size_.y() + root.y()) * size_.x() + root.x())];
  }
  /// As unsigned numbers, cells below the box are beyond it as well.
  bool is_outside(const Eigen::Vector3i& cell) const {
    const auto beyond = [&](int axis) {
      return static_cast<uint32_t>(cell[axis]) > static_cast<uint32_t>(last_cell_[axis]);
    };
    return beyond(0) | beyond(1) | beyond(2);
  }
  /// Goes down from nodes[layer], or from the root for layer -1.
  void go_down(int layer, const Eigen::Vector3i& cell, Descent* descent) const;

  const VoxelMap& map_;
  int leaf_layer_;
  Eigen::Vector3i low_;               // root key of the box's corner: cells count from there
  Eigen::Vector3i size_;              // of the box, roots
  Eigen::Vector3i last_cell_;         // of the box
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
  uint32_t node = descent->nodes[static_cast<size_t>(layer)];
  for (int shift = leaf_layer_ - layer - 1; shift >= 0; --shift) {
    const uint32_t child = map_.child_in_octant(layer, node, octant_of(shift_down(cell, shift)));
    if (child == no_voxel) break;
    node = child;
    descent->nodes[static_cast<size_t>(++layer)] = node;
  }
  descent->layer = layer;
}

template <typename Visit>
void LeafRayCaster::cast(const Eigen::Vector3d& direction_in_map, double distance_m, const Visit& visit) const {
  const double end = distance_m / map_.options().leaf_size_m;  // leaves, as all lengths here
  const Axis x(origin_in_leaves_.x(), direction_in_map.x());
  const Axis y(origin_in_leaves_.y(), direction_in_map.y());
  const Axis z(origin_in_leaves_.z(), direction_in_map.z());
  Eigen::Vector3i cell = origin_in_leaves_.cast<int>().cwiseMin(last_cell_);
  Descent descent;
  go_down(-1, cell, &descent);
  while (true) {
    const bool is_leaf = descent.layer == leaf_layer_;
    if (is_leaf) visit(descent.nodes[static_cast<size_t>(leaf_layer_)]);
    // The voxel to leave: the leaf, or the empty one below the lowest that exists.
    const int size = is_leaf ? 1 : 1 << (leaf_layer_ - descent.layer - 1);
    const int low_x = cell.x() & -size;
    const int low_y = cell.y() & -size;
    const int low_z = cell.z() & -size;
    const double exit_x = x.exit(low_x, size);
    const double exit_y = y.exit(low_y, size);
    const double exit_z = z.exit(low_z, size);
    const double exit = std::min(exit_x, std::min(exit_y, exit_z));
    if (!(exit < end)) return;
    const bool through_x = exit_x == exit;
    const bool through_y = !through_x & (exit_y == exit);
    const bool through_z = !through_x & !through_y;
    const Eigen::Vector3i next(x.next(through_x, exit, low_x, size), y.next(through_y, exit, low_y, size),
                               z.next(through_z, exit, low_z, size));
    if (is_outside(next)) return;
    const int changed = (cell.x() ^ next.x()) | (cell.y() ^ next.y()) | (cell.z() ^ next.z());
    cell = next;
    go_down(leaf_layer_ - std::bit_width(static_cast<uint32_t>(changed)), cell, &descent);
  }
}

}  // namespace cpplus
