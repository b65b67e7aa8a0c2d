#include "cpplus/report/point_tiles.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>

namespace cpplus {
namespace {

class TilePlanner {
 public:
  TilePlanner(const VoxelMap& map, const PointTileOptions& options)
      : map_(map),
        options_(options),
        levels_down_(static_cast<int>(std::lround(std::log2(options.voxels_along_edge)))) {
    assert(map.num_layers() > levels_down_);
  }

  std::vector<PointTile> plan() {
    Eigen::Vector3i least = map_.key(0, 0);
    for (uint32_t root = 0; root < map_.num_nodes(0); ++root) least = least.cwiseMin(map_.key(0, root));
    least_in_map_ = least.cast<double>() * map_.voxel_size(0);
    Level level;
    for (uint32_t root = 0; root < map_.num_nodes(0); ++root) {
      const Eigen::Vector3i key = map_.key(0, root) - least;
      level[{key.x(), key.y(), key.z()}] = add_node(0, root);
    }
    while (level.size() > 1) level = join(level);
    return std::move(tiles_);
  }

 private:
  // Tiles of one size by their place, counted from the least root so that doubling the size ends in one cube.
  using Level = std::map<std::array<int, 3>, uint32_t>;

  uint32_t add(PointTile tile) {
    tiles_.push_back(std::move(tile));
    return static_cast<uint32_t>(tiles_.size() - 1);
  }

  uint32_t add_node(int layer, uint32_t node) {
    PointTile tile;
    tile.size_m = map_.voxel_size(layer);
    tile.corner_in_map = map_.key(layer, node).cast<double>() * tile.size_m;
    tile.nodes = {{layer, node}};
    const bool has_finer = layer + levels_down_ <= map_.leaf_layer();
    if (has_finer && map_.num_points(layer, node) > options_.max_points) {
      tile.spacing_m = map_.voxel_size(layer + levels_down_);
      for (uint32_t child = map_.children_begin(layer, node); child < map_.children_end(layer, node); ++child) {
        tile.children.push_back(add_node(layer + 1, child));
      }
    }
    return add(std::move(tile));
  }

  // Cubes of twice the size over those of a level.
  Level join(const Level& level) {
    std::map<std::array<int, 3>, std::vector<uint32_t>> parents;
    for (const auto& [key, tile] : level) parents[{key[0] / 2, key[1] / 2, key[2] / 2}].push_back(tile);
    Level result;
    for (const auto& [key, children] : parents) result[key] = add_joined({key[0], key[1], key[2]}, children);
    return result;
  }

  uint32_t add_joined(const Eigen::Vector3i& key, const std::vector<uint32_t>& children) {
    PointTile tile;
    tile.size_m = 2.0 * tiles_[children.front()].size_m;
    tile.corner_in_map = least_in_map_ + key.cast<double>() * tile.size_m;
    tile.spacing_m = std::min(tile.size_m / options_.voxels_along_edge, map_.voxel_size(0));
    tile.children = children;
    for (uint32_t child : children) {
      tile.nodes.insert(tile.nodes.end(), tiles_[child].nodes.begin(), tiles_[child].nodes.end());
    }
    return add(std::move(tile));
  }

  const VoxelMap& map_;
  const PointTileOptions& options_;
  const int levels_down_;
  Eigen::Vector3d least_in_map_ = Eigen::Vector3d::Zero();
  std::vector<PointTile> tiles_;
};

// The mean of the points and of the colours of a run of points in map order.
void add_mean(const VoxelMap& map, uint32_t begin, uint32_t end, const std::vector<Rgb>& colors,
              const std::vector<uint8_t>& is_colored, const Eigen::Vector3d& origin_in_map, TilePoints* points) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d color = Eigen::Vector3d::Zero(), other_color = Eigen::Vector3d::Zero();
  size_t num_colored = 0;
  for (uint32_t i = begin; i < end; ++i) {
    const uint32_t input = map.input_index(i);
    position += map.point(i) - origin_in_map;
    const Eigen::Vector3d rgb(colors[input][0], colors[input][1], colors[input][2]);
    (is_colored[input] ? color : other_color) += rgb;
    num_colored += is_colored[input];
  }
  const double count = end - begin;
  points->positions.push_back(position / count);
  const Eigen::Vector3d mean = num_colored > 0 ? color / static_cast<double>(num_colored) : other_color / count;
  Rgb rounded;
  for (size_t i = 0; i < 3; ++i) {
    rounded[i] = static_cast<uint8_t>(std::lround(mean[static_cast<Eigen::Index>(i)]));
  }
  points->colors.push_back(rounded);
}

}  // namespace

std::vector<PointTile> plan_point_tiles(const VoxelMap& map, const PointTileOptions& options) {
  return TilePlanner(map, options).plan();
}

TilePoints gather_tile_points(const VoxelMap& map, const PointTile& tile, const std::vector<Rgb>& colors,
                              const std::vector<uint8_t>& is_colored, const Eigen::Vector3d& origin_in_map) {
  TilePoints points;
  const int layer = static_cast<int>(std::lround(std::log2(map.voxel_size(0) / std::max(tile.spacing_m, 1e-9))));
  for (const VoxelNode& node : tile.nodes) {
    if (tile.spacing_m == 0.0) {
      const uint32_t end = map.points_end(node.layer, node.index);
      for (uint32_t i = map.points_begin(node.layer, node.index); i < end; ++i) {
        points.positions.push_back(map.point(i) - origin_in_map);
        points.colors.push_back(colors[map.input_index(i)]);
      }
      continue;
    }
    uint32_t begin = node.index, end = node.index + 1;
    for (int l = node.layer; l < layer; ++l) {
      begin = map.children_begin(l, begin);
      end = map.children_begin(l, end);
    }
    for (uint32_t voxel = begin; voxel < end; ++voxel) {
      add_mean(map, map.points_begin(layer, voxel), map.points_end(layer, voxel), colors, is_colored, origin_in_map,
               &points);
    }
  }
  return points;
}

}  // namespace cpplus
