#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

struct VoxelMapOptions {
  /// Edge of the root voxels, metres. (0, inf)
  double root_size_m = 2.0;
  /// Edge of the leaf voxels, metres; root_size_m / leaf_size_m must be a power of two. (0, root_size_m]
  double leaf_size_m = 0.0625;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("root_size_m", root_size_m, "Edge of the root voxels, metres.");
    visitor("leaf_size_m", leaf_size_m, "Edge of the leaf voxels, metres; root / leaf must be a power of two.");
  }
};

/// Count, mean and covariance of the points in a voxel (Eq. 1 of Cui & Schwertfeger 2022).
struct VoxelStatistics {
  size_t count = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        // map frame, metres
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // divided by count, square metres
};

/// The multi-layer voxel map. Layer 0 holds the roots, layer num_layers() - 1 the leaves; only non-empty voxels exist.
/// Points are sorted by (root key, Morton code of the leaf inside the root), so every node of every layer is a
/// contiguous run of points, and of nodes of the layer below. Within a leaf, points keep the order of the input.
///
/// A node is named by (layer, index); nodes of a layer are in the order of their points.
class VoxelMap {
 public:
  VoxelMap() = default;
  /// Sorts the points and gathers the statistics of all layers. Non-finite points are dropped.
  VoxelMap(const PointCloud& cloud, const VoxelMapOptions& options);

  const VoxelMapOptions& options() const { return options_; }
  int num_layers() const { return static_cast<int>(layers_.size()); }
  int leaf_layer() const { return num_layers() - 1; }
  double voxel_size(int layer) const;

  size_t num_points() const { return positions_.size(); }
  const Eigen::Vector3d& origin() const { return origin_; }
  /// Points in map order; position in the map = origin() + positions()[i].
  const std::vector<Eigen::Vector3f>& positions() const { return positions_; }
  Eigen::Vector3d point(size_t i) const { return origin_ + positions_[i].cast<double>(); }
  /// Index of map-order point i in the input cloud.
  uint32_t input_index(size_t i) const { return input_indices_[i]; }

  uint32_t num_nodes(int layer) const;
  /// [begin, end) of the node's points, in map order.
  uint32_t points_begin(int layer, uint32_t node) const;
  uint32_t points_end(int layer, uint32_t node) const { return points_begin(layer, node + 1); }
  /// [begin, end) of the node's children in layer + 1.
  uint32_t children_begin(int layer, uint32_t node) const;
  uint32_t children_end(int layer, uint32_t node) const { return children_begin(layer, node + 1); }
  /// The node of layer - 1 that holds this one.
  uint32_t parent(int layer, uint32_t node) const;

  VoxelStatistics statistics(int layer, uint32_t node) const;

  /// Integer coordinates of a voxel of a layer: floor((x - grid origin) / voxel size). The grid origin is (0,0,0) of
  /// the map frame, whatever the cloud's origin.
  Eigen::Vector3i key(int layer, uint32_t node) const;
  Eigen::Vector3i key_of(int layer, const Eigen::Vector3d& x_in_map) const;
  /// Centre of the voxel (not the mean of its points), map frame, metres.
  Eigen::Vector3d center(int layer, uint32_t node) const;
  std::optional<uint32_t> find(int layer, const Eigen::Vector3i& key) const;

  /// Existing nodes among the 26 neighbours (6 with faces_only), ascending. Cleared and refilled.
  void neighbors(int layer, uint32_t node, bool faces_only, std::vector<uint32_t>* nodes) const;

  /// Roots that come within radius_m of the point, ascending.
  std::vector<uint32_t> roots_in_radius(const Eigen::Vector3d& x_in_map, double radius_m) const;

 private:
  struct Layer {
    std::vector<uint32_t> points_begin;    // size nodes + 1
    std::vector<uint32_t> children_begin;  // size nodes + 1; empty for the leaves
    std::vector<uint64_t> codes;           // Morton code inside the root, per node
    std::vector<uint32_t> root;            // root of the node
  };

  VoxelMapOptions options_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> positions_;
  std::vector<uint32_t> input_indices_;
  std::vector<Eigen::Vector3i> root_keys_;  // per root, in the order of the roots
  std::vector<Layer> layers_;
};

}  // namespace cpplus
