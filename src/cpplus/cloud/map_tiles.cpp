#include "cpplus/cloud/map_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace cpplus {
namespace {

/// A tile is at least this many roots across where it was halved: what lies around it is looked at as well.
constexpr int kFewestRootsAcross = 4;

struct KeyBox {
  Eigen::Vector3i min = Eigen::Vector3i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector3i max = Eigen::Vector3i::Constant(std::numeric_limits<int>::min());
};

KeyBox bounds_of(const VoxelMap& map, const std::vector<uint32_t>& roots) {
  KeyBox box;
  for (const uint32_t root : roots) {
    box.min = box.min.cwiseMin(map.arrays().root_keys[root]);
    box.max = box.max.cwiseMax(map.arrays().root_keys[root]);
  }
  return box;
}

size_t num_points_in(const VoxelMap& map, const std::vector<uint32_t>& roots) {
  size_t count = 0;
  for (const uint32_t root : roots) count += map.num_points(0, root);
  return count;
}

/// Both sides of the middle of the roots' longest extent; false where they are too near for that.
bool halve(const VoxelMap& map, const MapTile& whole, MapTile* lower, MapTile* upper) {
  const KeyBox bounds = bounds_of(map, whole.roots);
  Eigen::Index axis = 0;
  const int extent = (bounds.max - bounds.min).maxCoeff(&axis) + 1;
  if (extent < 2 * kFewestRootsAcross) return false;
  const int middle = bounds.min[axis] + extent / 2;
  *lower = {{}, whole.box};
  *upper = {{}, whole.box};
  lower->box.max()[axis] = upper->box.min()[axis] = middle * map.options().root_size_m;
  for (const uint32_t root : whole.roots) {
    (map.arrays().root_keys[root][axis] < middle ? lower : upper)->roots.push_back(root);
  }
  return true;
}

}  // namespace

std::vector<MapTile> divide_map(const VoxelMap& map, size_t max_points) {
  if (map.num_points() == 0) return {};
  std::vector<uint32_t> roots(map.num_nodes(0));
  std::iota(roots.begin(), roots.end(), 0u);
  return divide_roots(map, std::move(roots), max_points);
}

std::vector<MapTile> divide_roots(const VoxelMap& map, std::vector<uint32_t> roots, size_t max_points) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<MapTile> tiles;
  if (roots.empty()) return tiles;
  std::vector<MapTile> open(1);
  open[0].roots = std::move(roots);
  open[0].box = {Eigen::Vector3d::Constant(-kInfinity), Eigen::Vector3d::Constant(kInfinity)};
  while (!open.empty()) {
    const MapTile whole = std::move(open.back());
    open.pop_back();
    MapTile lower, upper;
    if (num_points_in(map, whole.roots) > max_points && halve(map, whole, &lower, &upper)) {
      open.push_back(std::move(upper));
      open.push_back(std::move(lower));
    } else {
      tiles.push_back(whole);
    }
  }
  return tiles;
}

std::vector<uint32_t> roots_around(const VoxelMap& map, const MapTile& tile, double halo_m) {
  const int halo = static_cast<int>(std::ceil(halo_m / map.options().root_size_m));
  const KeyBox bounds = bounds_of(map, tile.roots);
  const std::span<const Eigen::Vector3i> keys = map.arrays().root_keys;
  const auto by_x = [](const Eigen::Vector3i& key, int x) { return key.x() < x; };
  const auto begin = std::lower_bound(keys.begin(), keys.end(), bounds.min.x() - halo, by_x);
  const auto end = std::lower_bound(begin, keys.end(), bounds.max.x() + halo + 1, by_x);
  std::vector<uint32_t> roots;
  for (auto key = begin; key != end; ++key) {
    const bool is_near =
        (key->array() >= bounds.min.array() - halo).all() && (key->array() <= bounds.max.array() + halo).all();
    if (is_near) roots.push_back(static_cast<uint32_t>(key - keys.begin()));
  }
  return roots;
}

}  // namespace cpplus
