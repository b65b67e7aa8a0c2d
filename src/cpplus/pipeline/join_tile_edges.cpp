#include "cpplus/pipeline/join_tile_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "cpplus/pipeline/tile_features.h"

namespace cpplus {
namespace {

constexpr double kParallelCos = 0.97;
// Shorter remainders of an edge that another tile has as well are given up, metres.
constexpr double kMinRemainderM = 0.1;

/// A stretch along an edge, metres from its start.
using Stretch = std::pair<double, double>;

double longest_m(const std::vector<TileFeatures>& features) {
  double longest = 0.0;
  for (const TileFeatures& tile : features) {
    for (const MapEdge& edge : tile.edges) longest = std::max(longest, edge.length());
  }
  return longest;
}

class EdgeJoiner {
 public:
  explicit EdgeJoiner(double longest_edge_m) : reach_m_(longest_edge_m + kTileEdgeOverlapM) {}

  void add(const MapTile& tile, const std::vector<MapEdge>& edges) {
    const auto first_group = static_cast<uint32_t>(parent_.size());
    const Eigen::AlignedBox3d inner(tile.box.min().array() + reach_m_, tile.box.max().array() - reach_m_);
    const size_t num_before = edges_.size();
    for (MapEdge edge : edges) {
      edge.group += first_group;
      while (parent_.size() <= edge.group) parent_.push_back(static_cast<uint32_t>(parent_.size()));
      if (inner.contains(edge.start) && inner.contains(edge.end)) {
        edges_.push_back(edge);
      } else {
        add_remainders(edge);
      }
    }
    // Only now: a tile's own edges do not stand in each other's way.
    for (size_t k = num_before; k < edges_.size(); ++k) {
      if (inner.contains(edges_[k].start) && inner.contains(edges_[k].end)) continue;
      at_borders_[cell_of(edges_[k])].push_back(k);
    }
  }

  std::vector<MapEdge> take() {
    for (MapEdge& edge : edges_) edge.group = find(edge.group);
    return std::move(edges_);
  }

 private:
  using Cell = std::array<int64_t, 3>;

  /// Of its middle: edges that share a stretch are in neighbouring cells.
  Cell cell_of(const MapEdge& edge) const {
    const Eigen::Vector3d cell = (0.5 * (edge.start + edge.end) / reach_m_).array().floor();
    return {static_cast<int64_t>(cell.x()), static_cast<int64_t>(cell.y()), static_cast<int64_t>(cell.z())};
  }

  template <typename Body>
  void for_each_near(const MapEdge& edge, const Body& body) const {
    const Cell center = cell_of(edge);
    for (int k = 0; k < 27; ++k) {
      const auto cell = at_borders_.find({center[0] + k / 9 - 1, center[1] + k / 3 % 3 - 1, center[2] + k % 3 - 1});
      if (cell == at_borders_.end()) continue;
      for (const size_t other : cell->second) body(edges_[other]);
    }
  }

  /// The stretch of an edge that runs along another one.
  static std::optional<Stretch> shared_stretch(const MapEdge& edge, const MapEdge& other) {
    const Eigen::Vector3d direction = edge.direction();
    if (std::abs(direction.dot(other.direction())) < kParallelCos) return std::nullopt;
    const double s = direction.dot(other.start - edge.start);
    const double e = direction.dot(other.end - edge.start);
    const double begin = std::max(0.0, std::min(s, e));
    const double end = std::min(edge.length(), std::max(s, e));
    if (begin > end) return std::nullopt;
    const Eigen::Vector3d middle = edge.start + 0.5 * (begin + end) * direction;
    const Eigen::Vector3d from_other = middle - other.start;
    const Eigen::Vector3d along_other = other.direction();
    const double apart_m = (from_other - along_other.dot(from_other) * along_other).norm();
    if (apart_m > kTileEdgeOverlapM) return std::nullopt;
    return Stretch(begin, end);
  }

  static std::vector<Stretch> without(const std::vector<Stretch>& stretches, const Stretch& taken) {
    std::vector<Stretch> left;
    for (const Stretch& stretch : stretches) {
      const Stretch before(stretch.first, std::min(stretch.second, taken.first));
      const Stretch after(std::max(stretch.first, taken.second), stretch.second);
      for (const Stretch& part : {before, after}) {
        if (part.second - part.first >= kMinRemainderM) left.push_back(part);
      }
    }
    return left;
  }

  /// What of an edge the tiles before do not have.
  void add_remainders(const MapEdge& edge) {
    const Stretch whole(0.0, edge.length());
    std::vector<Stretch> left = {whole};
    for_each_near(edge, [&](const MapEdge& other) {
      const auto shared = shared_stretch(edge, other);
      if (!shared) return;
      if (edge.kind == other.kind) unite(edge.group, other.group);
      left = without(left, *shared);
    });
    for (const Stretch& stretch : left) {
      MapEdge part = edge;
      if (stretch != whole) {
        part.start = edge.start + stretch.first * edge.direction();
        part.end = edge.start + stretch.second * edge.direction();
      }
      edges_.push_back(part);
    }
  }

  uint32_t find(uint32_t group) const {
    while (parent_[group] != group) group = parent_[group];
    return group;
  }

  void unite(uint32_t a, uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  double reach_m_;
  std::vector<MapEdge> edges_;
  std::map<Cell, std::vector<size_t>> at_borders_;  // edges near the borders of the tiles before
  std::vector<uint32_t> parent_;                    // of the groups
};

}  // namespace

std::vector<MapEdge> join_tile_edges(const std::vector<const MapTile*>& tiles,
                                     const std::vector<TileFeatures>& features) {
  EdgeJoiner joiner(longest_m(features));
  for (size_t t = 0; t < tiles.size(); ++t) joiner.add(*tiles[t], features[t].edges);
  return joiner.take();
}

}  // namespace cpplus
