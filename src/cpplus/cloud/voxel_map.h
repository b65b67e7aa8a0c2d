#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map_arrays.h"
#include "cpplus/cloud/voxel_map_grid.h"

namespace cpplus {

struct VoxelMapOptions {
  /// Edge of the root voxels, metres. (0, inf)
  double root_size_m = 2.0;
  /// Edge of the leaf voxels, metres; root_size_m / leaf_size_m must be a power of two up to 1024.
  /// (0, root_size_m]
  double leaf_size_m = 0.0625;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("root_size_m", root_size_m, "Edge of the root voxels, metres.");
    visitor("leaf_size_m", leaf_size_m,
            "Edge of the leaf voxels, metres; root / leaf must be a power of two up to 1024.");
  }
};

/// Count, mean and covariance of the points in a voxel (Eq. 1 of Cui & Schwertfeger 2022).
struct VoxelStatistics {
  size_t count = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        // map frame, metres
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // divided by count, square metres
};

/// A non-empty voxel.
struct VoxelNode {
  int layer = 0;
  uint32_t index = 0;
};

/// The multi-layer voxel map. Layer 0 holds the roots, layer num_layers() - 1 the leaves; only non-empty voxels exist.
/// Points are sorted by (root key, Morton code of the leaf inside the root), so every node of every layer is a
/// contiguous run of points, and of nodes of the layer below. Within a leaf, points keep the order of the input.
///
/// A node is named by (layer, index); nodes of a layer are in the order of their points. Immutable; copies share the
/// arrays. All queries are safe from several threads.
class VoxelMap {
 public:
  VoxelMap() = default;
  /// Sorts the points and gathers the statistics of all layers, in time linear in the points. Non-finite points are
  /// dropped. Throws Error for a finite point beyond 2^30 leaves from the grid origin (67,000 km for 62.5 mm leaves),
  /// and for more than 2^32 - 2 points.
  VoxelMap(const PointCloud& cloud, const VoxelMapOptions& options);
  /// A map that was built before, from its arrays; `origin` is that of its points, map frame, metres.
  VoxelMap(const Eigen::Vector3d& origin, const VoxelMapOptions& options, VoxelMapArrays arrays);

  const VoxelMapOptions& options() const { return options_; }
  int num_layers() const { return static_cast<int>(arrays_.layers.size()); }
  int leaf_layer() const { return num_layers() - 1; }
  double voxel_size(int layer) const { return options_.root_size_m / static_cast<double>(1 << layer); }

  size_t num_points() const { return arrays_.positions.size(); }
  /// Non-finite points of the input, which the map left out.
  size_t num_dropped() const { return arrays_.num_dropped; }
  /// Bytes of all arrays.
  size_t memory_bytes() const;
  const VoxelMapArrays& arrays() const { return arrays_; }
  const Eigen::Vector3d& origin() const { return grid_.origin; }
  /// Points in map order; position in the map = origin() + positions()[i].
  std::span<const Eigen::Vector3f> positions() const { return arrays_.positions; }
  Eigen::Vector3d point(size_t i) const { return grid_.origin + arrays_.positions[i].cast<double>(); }
  /// Index of map-order point i in the input cloud.
  uint32_t input_index(size_t i) const { return arrays_.input_indices[i]; }

  uint32_t num_nodes(int layer) const { return static_cast<uint32_t>(this->layer(layer).first.size() - 1); }
  /// [begin, end) of the node's points, in map order. One step a layer down to the leaves.
  uint32_t points_begin(int layer, uint32_t node) const {
    for (; layer < leaf_layer(); ++layer) node = this->layer(layer).first[node];
    return this->layer(layer).first[node];
  }
  uint32_t points_end(int layer, uint32_t node) const { return points_begin(layer, node + 1); }
  /// [begin, end) of the node's children in layer + 1; not for leaves.
  uint32_t children_begin(int layer, uint32_t node) const { return this->layer(layer).first[node]; }
  uint32_t children_end(int layer, uint32_t node) const { return children_begin(layer, node + 1); }
  /// The child in an octant (octant_of() of its key) of a node above the leaves, no_voxel where it is empty.
  uint32_t child_in_octant(int layer, uint32_t node, int octant) const {
    const VoxelMapLayer& nodes = this->layer(layer);
    const uint32_t mask = nodes.child_mask[node];
    const uint32_t bit = 1u << octant;
    return (mask & bit) != 0 ? nodes.first[node] + bit_counts[mask & (bit - 1)] : no_voxel;
  }
  /// The node of layer - 1 that holds this one; not for roots.
  uint32_t parent(int layer, uint32_t node) const;

  size_t num_points(int layer, uint32_t node) const { return points_end(layer, node) - points_begin(layer, node); }
  /// Stored for nodes above the leaves with many points (exact to float32 relative to the root's centre), otherwise
  /// summed here in two passes over the node's points.
  VoxelStatistics statistics(int layer, uint32_t node) const;

  /// Integer coordinates of a voxel of a layer: floor((x - grid origin) / voxel size). The grid origin is (0,0,0) of
  /// the map frame, whatever the cloud's origin.
  Eigen::Vector3i key(int layer, uint32_t node) const;
  /// Positions beyond the limit of the grid get the key at the limit, where no voxel exists.
  Eigen::Vector3i key_of(int layer, const Eigen::Vector3d& x_in_map) const;
  /// Centre of the voxel (not the mean of its points), map frame, metres.
  Eigen::Vector3d center(int layer, uint32_t node) const {
    return (key(layer, node).cast<double>().array() + 0.5) * voxel_size(layer);
  }
  std::optional<uint32_t> find(int layer, const Eigen::Vector3i& key) const;
  /// The leaf that holds the position.
  std::optional<uint32_t> find_leaf(const Eigen::Vector3d& x_in_map) const {
    return find(leaf_layer(), key_of(leaf_layer(), x_in_map));
  }
  /// The lowest node that holds the cell (a key of the leaf layer), nothing where the root is empty. A ray may leave
  /// the empty voxel of the layer below the result in one step.
  std::optional<VoxelNode> find_lowest(const Eigen::Vector3i& cell) const;

  /// Existing nodes among the 26 neighbours (6 with faces_only), ascending. Cleared and refilled.
  void neighbors(int layer, uint32_t node, bool faces_only, std::vector<uint32_t>* nodes) const;

  /// Roots that come within radius_m of the point, ascending. Cost grows with the slab of roots within the radius in x.
  std::vector<uint32_t> roots_in_radius(const Eigen::Vector3d& x_in_map, double radius_m) const;
  /// Roots that come within radius_m of the apex and may meet the cone, ascending. A superset: each root is tested by
  /// its circumscribed sphere. The axis has unit length; half_angle in [0, pi], pi keeps the whole ball.
  std::vector<uint32_t> roots_in_frustum(const Eigen::Vector3d& apex_in_map, const Eigen::Vector3d& axis_in_map,
                                         double half_angle, double radius_m) const;

 private:
  const VoxelMapLayer& layer(int layer) const { return arrays_.layers[static_cast<size_t>(layer)]; }
  uint32_t find_root(const Eigen::Vector3i& key) const;

  VoxelMapOptions options_;
  VoxelGrid grid_;
  VoxelMapArrays arrays_;
};

}  // namespace cpplus
