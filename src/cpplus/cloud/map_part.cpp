#include "cpplus/cloud/map_part.h"

#include <bit>
#include <functional>

#include "cpplus/cloud/owned_map_arrays.h"
#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

/// Consecutive nodes, or points.
struct Run {
  uint32_t begin = 0;
  uint32_t end = 0;
};

/// Of each layer, roots first, and at the end of the points.
using Runs = std::vector<std::vector<Run>>;

Runs runs_of_roots(const VoxelMap& map, std::span<const uint32_t> roots) {
  Runs runs(static_cast<size_t>(map.num_layers()) + 1);
  for (const uint32_t root : roots) {
    if (!runs[0].empty() && runs[0].back().end == root) {
      ++runs[0].back().end;
    } else {
      runs[0].push_back({root, root + 1});
    }
  }
  for (size_t l = 0; l + 1 < runs.size(); ++l) {
    const std::span<const uint32_t> first = map.arrays().layers[l].first;
    for (const Run& run : runs[l]) runs[l + 1].push_back({first[run.begin], first[run.end]});
  }
  return runs;
}

size_t total_size(const std::vector<Run>& runs) {
  size_t size = 0;
  for (const Run& run : runs) size += run.end - run.begin;
  return size;
}

template <typename T>
std::vector<T> gather(std::span<const T> values, const std::vector<Run>& runs) {
  std::vector<T> gathered;
  if (values.empty()) return gathered;
  gathered.reserve(total_size(runs));
  for (const Run& run : runs) {
    const std::span<const T> some = values.subspan(run.begin, run.end - run.begin);
    gathered.insert(gathered.end(), some.begin(), some.end());
  }
  return gathered;
}

/// What the part's arrays lie in.
struct Part {
  std::vector<Eigen::Vector3f> positions;
  std::vector<uint32_t> input_indices;
  std::vector<Eigen::Vector3i> root_keys;
  std::vector<uint32_t> root_table;
  std::vector<OwnedLayer> layers;
  OwnedAttributes attributes;
};

void gather_moments(const VoxelMapLayer& from, const std::vector<Run>& runs, OwnedLayer* layer) {
  const auto is_stored = [&](uint32_t node) { return (from.moments_mask[node / 64] >> (node % 64) & 1) != 0; };
  uint32_t node_in_part = 0;
  for (const Run& run : runs) {
    const uint64_t before = (uint64_t{1} << (run.begin % 64)) - 1;
    size_t next = from.moments_rank[run.begin / 64] +
                  static_cast<size_t>(std::popcount(from.moments_mask[run.begin / 64] & before));
    for (uint32_t node = run.begin; node < run.end; ++node, ++node_in_part) {
      if (node_in_part % 64 == 0) {
        layer->moments_mask.push_back(0);
        layer->moments_rank.push_back(static_cast<uint32_t>(layer->moments.size()));
      }
      if (!is_stored(node)) continue;
      layer->moments_mask.back() |= uint64_t{1} << (node_in_part % 64);
      layer->moments.push_back(from.moments[next++]);
    }
  }
}

OwnedLayer gather_layer(const VoxelMapLayer& from, bool is_leaf, const std::vector<Run>& runs,
                        const std::vector<Run>& runs_below) {
  OwnedLayer layer;
  layer.first.reserve(total_size(runs) + 1);
  uint32_t num_below = 0;
  for (size_t k = 0; k < runs.size(); ++k) {
    for (uint32_t node = runs[k].begin; node < runs[k].end; ++node) {
      layer.first.push_back(from.first[node] - runs_below[k].begin + num_below);
    }
    num_below += runs_below[k].end - runs_below[k].begin;
  }
  layer.first.push_back(num_below);
  if (is_leaf) return layer;
  layer.child_mask = gather(from.child_mask, runs);
  gather_moments(from, runs, &layer);
  return layer;
}

/// Turns the indices of some points of the input into their order among these.
void rank_indices(size_t num_points, std::vector<uint32_t>* indices) {
  std::vector<uint64_t> is_there((num_points + 63) / 64, 0);
  for (const uint32_t index : *indices) {
    const uint64_t bit = uint64_t{1} << (index % 64);
    if (index >= num_points || (is_there[index / 64] & bit) != 0) {
      throw Error("the indices of the map's points are damaged");
    }
    is_there[index / 64] |= bit;
  }
  std::vector<uint32_t> before;
  before.reserve(is_there.size());
  uint32_t count = 0;
  for (const uint64_t word : is_there) {
    before.push_back(count);
    count += static_cast<uint32_t>(std::popcount(word));
  }
  for (uint32_t& index : *indices) {
    const uint64_t lower = (uint64_t{1} << (index % 64)) - 1;
    index = before[index / 64] + static_cast<uint32_t>(std::popcount(is_there[index / 64] & lower));
  }
}

Part gather_part(const PointMap& points, std::span<const uint32_t> roots) {
  const VoxelMapArrays& arrays = points.map.arrays();
  const Runs runs = runs_of_roots(points.map, roots);
  Part part;
  part.root_keys = gather(arrays.root_keys, runs[0]);
  part.root_table = make_root_table(part.root_keys);
  part.layers.resize(arrays.layers.size());
  OwnedAttributes& attributes = part.attributes;
  std::vector<std::function<void()>> tasks = {
      [&] { part.positions = gather(arrays.positions, runs.back()); },
      [&] {
        part.input_indices = gather(arrays.input_indices, runs.back());
        rank_indices(arrays.positions.size(), &part.input_indices);
      },
      [&] { attributes.intensities = gather(points.intensities, runs.back()); },
      [&] { attributes.colors = gather(points.colors, runs.back()); },
      [&] { attributes.stamps_s = gather(points.stamps_s, runs.back()); },
      [&] { attributes.num_views = gather(points.num_views, runs.back()); },
      [&] { attributes.best_images = gather(points.best_images, runs.back()); },
      [&] { attributes.color_spreads = gather(points.color_spreads, runs.back()); }};
  for (size_t l = 0; l < arrays.layers.size(); ++l) {
    tasks.emplace_back([&, l] {
      part.layers[l] = gather_layer(arrays.layers[l], l + 1 == arrays.layers.size(), runs[l], runs[l + 1]);
    });
  }
  parallel_for_each(tasks.size(), [&](size_t i) { tasks[i](); });
  return part;
}

}  // namespace

std::vector<uint32_t> roots_near(const VoxelMap& map, std::span<const Eigen::Vector3d> places_in_map, double radius_m) {
  std::vector<bool> is_near(map.arrays().root_keys.size(), false);
  for (const Eigen::Vector3d& place : places_in_map) {
    for (const uint32_t root : map.roots_in_radius(place, radius_m)) is_near[root] = true;
  }
  std::vector<uint32_t> roots;
  for (uint32_t root = 0; root < is_near.size(); ++root) {
    if (is_near[root]) roots.push_back(root);
  }
  return roots;
}

PointMap part_of_map(const PointMap& points, std::span<const uint32_t> roots) {
  const VoxelMap& map = points.map;
  if (roots.size() == map.arrays().root_keys.size()) return points;
  const auto part = std::make_shared<const Part>(gather_part(points, roots));
  VoxelMapArrays arrays;
  arrays.positions = part->positions;
  arrays.input_indices = part->input_indices;
  arrays.root_keys = part->root_keys;
  arrays.root_table = part->root_table;
  for (const OwnedLayer& layer : part->layers) arrays.layers.push_back(layer.view());
  arrays.owner = part;
  PointMap result;
  result.map = VoxelMap(map.origin(), map.options(), std::move(arrays));
  result.las_frame = points.las_frame;
  part->attributes.view(part, &result);
  return result;
}

}  // namespace cpplus
