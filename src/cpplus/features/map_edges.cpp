#include "cpplus/features/map_edges.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace cpplus {
namespace {

constexpr double kCell = 0.25;  // metres
constexpr double kParallelCos = 0.97;
constexpr double kCoveredShare = 0.6;

int64_t cell_key(const Eigen::Vector3d& x) {
  const Eigen::Vector3i c = (x / kCell).array().floor().cast<int>();
  return (static_cast<int64_t>(c.x() & 0x1FFFFF) << 42) | (static_cast<int64_t>(c.y() & 0x1FFFFF) << 21) |
         static_cast<int64_t>(c.z() & 0x1FFFFF);
}

// Edges by the cells that they pass through or near.
class EdgeGrid {
 public:
  explicit EdgeGrid(double separation_m) : separation_(separation_m) {}

  void add(const MapEdge& edge) {
    const int steps = 1 + static_cast<int>(edge.length() / (0.5 * kCell));
    const uint32_t index = static_cast<uint32_t>(edges_.size());
    edges_.push_back(edge);
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector3d x = edge.start + static_cast<double>(k) / steps * (edge.end - edge.start);
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d offset(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        std::vector<uint32_t>& cell = cells_[cell_key(x + separation_ * offset)];
        if (cell.empty() || cell.back() != index) cell.push_back(index);
      }
    }
  }

  // Most of the edge runs along edges that are already here.
  bool covers(const MapEdge& edge) const {
    constexpr int kSamples = 9;
    int covered = 0;
    for (int k = 0; k < kSamples; ++k)
      covered += has_parallel(edge, edge.start + (k + 0.5) / kSamples * (edge.end - edge.start));
    return covered >= kCoveredShare * kSamples;
  }

 private:
  bool has_parallel(const MapEdge& edge, const Eigen::Vector3d& x) const {
    const auto cell = cells_.find(cell_key(x));
    if (cell == cells_.end()) return false;
    return std::any_of(cell->second.begin(), cell->second.end(), [&](uint32_t i) {
      const Eigen::Vector3d along = edges_[i].end - edges_[i].start;
      if (std::abs(edges_[i].direction().dot(edge.direction())) < kParallelCos) return false;
      const double t = (x - edges_[i].start).dot(along) / along.squaredNorm();
      return t >= 0 && t <= 1 && (x - edges_[i].start - t * along).norm() < separation_;
    });
  }

  double separation_;
  std::vector<MapEdge> edges_;
  std::unordered_map<int64_t, std::vector<uint32_t>> cells_;
};

}  // namespace

void MapEdgeOptions::validate() const {
  crease.validate();
  boundary.validate();
  intensity.validate();
  check_option(min_separation_m >= 0, "min_separation_m", "[0, inf)", min_separation_m);
}

std::vector<MapEdge> find_map_edges(const VoxelMap& map, std::span<const float> intensities,
                                    const PlaneSegmentation& planes, const MapEdgeOptions& options) {
  options.validate();
  const std::vector<std::vector<MapEdge>> kinds = {find_crease_edges(map, planes, options.crease),
                                                   find_intensity_edges(map, intensities, planes, options.intensity),
                                                   find_boundary_edges(map, planes, options.boundary)};
  // Best known kind first: intersections of planes, then steps fitted to points of both sides, then one-sided borders.
  EdgeGrid grid(options.min_separation_m);
  std::vector<std::vector<MapEdge>> kept(kinds.size());
  for (size_t kind = 0; kind < kinds.size(); ++kind) {
    for (const MapEdge& edge : kinds[kind]) {
      if (kind == 0 || !grid.covers(edge)) kept[kind].push_back(edge);
    }
    for (const MapEdge& edge : kept[kind]) grid.add(edge);
  }
  return concatenate_groups(kept);
}

}  // namespace cpplus
