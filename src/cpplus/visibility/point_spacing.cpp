#include "cpplus/visibility/point_spacing.h"

#include <cmath>
#include <limits>
#include <utility>

namespace cpplus {
namespace {

constexpr double kNodeM = 0.25;  // the surroundings of a node are the 3x3x3 around it
constexpr double kPointsPerCell = 2.5;

// Points, then occupied cells layer by layer from that of the nodes to the leaves.
using Counts = std::vector<uint32_t>;

Counts count_in(const VoxelMap& map, int layer, uint32_t node) {
  Counts counts = {static_cast<uint32_t>(map.num_points(layer, node)), 1};
  std::pair<uint32_t, uint32_t> cells = {node, node + 1};
  for (; layer < map.leaf_layer(); ++layer) {
    cells = {map.children_begin(layer, cells.first), map.children_begin(layer, cells.second)};
    counts.push_back(cells.second - cells.first);
  }
  return counts;
}

double finest_spacing(const VoxelMap& map, int layer, const Counts& counts) {
  double finest = std::numeric_limits<double>::infinity();
  const double num_points = counts[0];
  for (size_t k = 1; k < counts.size(); ++k, ++layer) {
    const double num_cells = counts[k];
    if (num_points >= kPointsPerCell * num_cells) finest = map.voxel_size(layer) * std::sqrt(num_cells / num_points);
  }
  return finest;
}

}  // namespace

int point_spacing_layer(const VoxelMap& map) {
  int layer = map.leaf_layer();
  while (layer > 0 && map.voxel_size(layer - 1) <= kNodeM * 1.001) --layer;
  return layer;
}

std::vector<float> leaf_point_spacing(const VoxelMap& map) {
  if (map.num_layers() == 0) return {};
  const int layer = point_spacing_layer(map);

  std::vector<Counts> counts;
  counts.reserve(map.num_nodes(layer));
  for (uint32_t node = 0; node < map.num_nodes(layer); ++node) counts.push_back(count_in(map, layer, node));

  std::vector<float> spacing(map.num_nodes(map.leaf_layer()));
  std::vector<uint32_t> around;
  for (uint32_t node = 0, leaf = 0; node < map.num_nodes(layer); ++node) {
    Counts sum = counts[node];
    map.neighbors(layer, node, false, &around);
    for (const uint32_t neighbor : around) {
      for (size_t k = 0; k < sum.size(); ++k) sum[k] += counts[neighbor][k];
    }
    const float finest = static_cast<float>(finest_spacing(map, layer, sum));
    for (const uint32_t end = leaf + counts[node].back(); leaf < end; ++leaf) spacing[leaf] = finest;
  }
  return spacing;
}

}  // namespace cpplus
