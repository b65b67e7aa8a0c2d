#include "cpplus/visibility/extended_surfaces.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cpplus {
namespace {

constexpr int32_t kNone = -1;

/// Count, sum of x y z, sum of xx xy xz yy yz zz over leaf means relative to a common reference point.
using Moments = Eigen::Matrix<double, 10, 1>;

std::pair<uint32_t, uint32_t> descend(const VoxelMap& map, int from_layer, uint32_t node, int to_layer) {
  uint32_t begin = node;
  uint32_t end = node + 1;
  for (int l = from_layer; l < to_layer; ++l) {
    begin = map.children_begin(l, begin);
    end = map.children_begin(l, end);
  }
  return {begin, end};
}

Moments gather_moments(const VoxelMap& map, int layer, uint32_t node, const Eigen::Vector3f& reference) {
  Moments moments = Moments::Zero();
  const int leaf_layer = map.leaf_layer();
  const auto [begin, end] = descend(map, layer, node, leaf_layer);
  for (uint32_t leaf = begin; leaf < end; ++leaf) {
    const uint32_t points_begin = map.points_begin(leaf_layer, leaf);
    const uint32_t points_end = map.points_end(leaf_layer, leaf);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (uint32_t i = points_begin; i < points_end; ++i) sum += map.positions()[i] - reference;
    const Eigen::Vector3d x = (sum / static_cast<float>(points_end - points_begin)).cast<double>();
    moments += (Moments() << 1.0, x, x.x() * x, x.y() * x.tail<2>(), x.z() * x.z()).finished();
  }
  return moments;
}

/// The nodes of some roots, numbered one root after the other, with neighbours in constant time.
class NodeGrid {
 public:
  NodeGrid(const VoxelMap& map, const std::vector<uint32_t>& roots, int layer)
      : bits_(layer), cells_(static_cast<size_t>(1) << (3 * layer)), nodes_(roots.size() * cells_, kNone) {
    if (roots.empty()) return;
    const Eigen::Vector3f reference = (map.center(0, roots.front()) - map.origin()).cast<float>();
    for (size_t r = 0; r < roots.size(); ++r) {
      const Eigen::Vector3i first_cell = map.key(0, roots[r]) * (1 << bits_);
      const auto [begin, end] = descend(map, 0, roots[r], layer);
      for (uint32_t node = begin; node < end; ++node) {
        const Eigen::Vector3i cell = map.key(layer, node) - first_cell;
        nodes_[r * cells_ + offset(cell)] = static_cast<int32_t>(moments_.size());
        places_.push_back({r, cell});
        moments_.push_back(gather_moments(map, layer, node, reference));
      }
      links_.push_back(link_root(map, roots, roots[r]));
    }
  }

  size_t size() const { return moments_.size(); }
  const Moments& moments(size_t node) const { return moments_[node]; }

  /// The node at a step of -1, 0 or 1 along each axis; kNone where it is empty or its root was not given.
  int32_t neighbor(size_t node, const Eigen::Vector3i& step) const {
    const Eigen::Vector3i cell = places_[node].cell + step;
    const int side = 1 << bits_;
    const Eigen::Vector3i hop = cell.unaryExpr([&](int v) { return v >> bits_; });
    const int32_t root = links_[places_[node].root][link(hop)];
    return root == kNone ? kNone : nodes_[static_cast<size_t>(root) * cells_ + offset(cell - hop * side)];
  }

 private:
  struct Place {
    size_t root;  // index in the given roots
    Eigen::Vector3i cell;
  };
  using Links = std::array<int32_t, 27>;

  static size_t link(const Eigen::Vector3i& hop) {
    return static_cast<size_t>((hop.x() + 1) * 9 + (hop.y() + 1) * 3 + hop.z() + 1);
  }
  size_t offset(const Eigen::Vector3i& cell) const {
    return static_cast<size_t>((((cell.x() << bits_) | cell.y()) << bits_) | cell.z());
  }

  static Links link_root(const VoxelMap& map, const std::vector<uint32_t>& roots, uint32_t root) {
    Links links;
    links.fill(kNone);
    std::vector<uint32_t> around;
    map.neighbors(0, root, false, &around);
    around.push_back(root);
    for (const uint32_t other : around) {
      const auto place = std::lower_bound(roots.begin(), roots.end(), other);
      if (place != roots.end() && *place == other)
        links[link(map.key(0, other) - map.key(0, root))] = static_cast<int32_t>(place - roots.begin());
    }
    return links;
  }

  int bits_;      // a root has 2^bits nodes along an edge
  size_t cells_;  // of a root
  std::vector<int32_t> nodes_;
  std::vector<Place> places_;
  std::vector<Moments> moments_;
  std::vector<Links> links_;  // the 27 roots around each root, as indices in the given ones
};

/// Whether the second largest eigenvalue of the covariance is at least min_variance.
bool spreads_over_an_area(const Moments& m, double min_variance) {
  const Eigen::Vector3d mean = m.segment<3>(1) / m[0];
  Eigen::Matrix3d squares;
  squares << m[4], m[5], m[6], m[5], m[7], m[8], m[6], m[8], m[9];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(squares / m[0] - mean * mean.transpose(), Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[1] >= min_variance;
}

}  // namespace

std::vector<uint8_t> find_extended_nodes(const VoxelMap& map, const std::vector<uint32_t>& roots, int layer,
                                         double min_extent) {
  const NodeGrid grid(map, roots, layer);
  const double min_deviation = min_extent * 3.0 * map.voxel_size(layer) / std::sqrt(12.0);
  std::vector<uint8_t> spread(grid.size());
  for (size_t node = 0; node < grid.size(); ++node) {
    Moments around = Moments::Zero();
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const int32_t neighbor = grid.neighbor(node, {x, y, z});
          if (neighbor != kNone) around += grid.moments(static_cast<size_t>(neighbor));
        }
      }
    }
    spread[node] = spreads_over_an_area(around, min_deviation * min_deviation);
  }
  std::vector<uint8_t> extended = spread;
  for (size_t node = 0; node < grid.size(); ++node) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        const int32_t neighbor = grid.neighbor(node, side * Eigen::Vector3i::Unit(axis));
        if (neighbor != kNone && spread[static_cast<size_t>(neighbor)]) extended[node] = 1;
      }
    }
  }
  return extended;
}

}  // namespace cpplus
