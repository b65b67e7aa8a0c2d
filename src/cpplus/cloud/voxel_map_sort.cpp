#include "cpplus/cloud/voxel_map_sort.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "cpplus/cloud/root_counts.h"
#include "cpplus/cloud/voxel_map_grid.h"
#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

// Few chunks, because each has its own counters; their number must not depend on the number of threads.
constexpr size_t min_chunk_size = 1 << 16;
constexpr size_t max_num_chunks = 32;

struct Chunk {
  RootCounts roots;  // their counts become the places where the next point of each root goes
  std::optional<size_t> beyond_limit;
};

void throw_if_beyond_limit(const PointCloud& cloud, const VoxelMapOptions& options, const std::vector<Chunk>& chunks) {
  for (const Chunk& chunk : chunks) {
    if (!chunk.beyond_limit) continue;
    const size_t i = *chunk.beyond_limit;
    throw Error(beyond_grid_message(i, cloud.point(i), options.leaf_size_m));
  }
}

/// Gathers the roots of all chunks, ascending, and turns each chunk's counts into the places of its points: root by
/// root, and inside a root chunk by chunk, which keeps the order of the input.
void place_chunks(std::vector<Chunk>* chunks, PointsByRoot* sorted) {
  std::vector<Eigen::Vector3i>& keys = sorted->root_keys;
  RootCounts all;
  for (const Chunk& chunk : *chunks) {
    for (const Eigen::Vector3i& key : chunk.roots.keys) all.add(key, 0);
  }
  keys = std::move(all.keys);
  std::sort(keys.begin(), keys.end(), key_less);
  const std::vector<uint32_t> table = make_key_table(keys, 2 * keys.size());

  std::vector<uint32_t>& begin = sorted->points_begin;
  begin.assign(keys.size() + 1, 0);
  std::vector<std::vector<uint32_t>> root_of_chunk_root(chunks->size());
  for (size_t c = 0; c < chunks->size(); ++c) {
    const RootCounts& roots = (*chunks)[c].roots;
    for (size_t r = 0; r < roots.keys.size(); ++r) {
      const uint32_t root = table[probe_key_table(table, keys, roots.keys[r])];
      root_of_chunk_root[c].push_back(root);
      begin[root + 1] += roots.counts[r];
    }
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
  for (size_t c = 0; c < chunks->size(); ++c) {
    std::vector<uint32_t>& counts = (*chunks)[c].roots.counts;
    for (size_t r = 0; r < counts.size(); ++r) {
      const uint32_t count = counts[r];
      counts[r] = next[root_of_chunk_root[c][r]];
      next[root_of_chunk_root[c][r]] += count;
    }
  }
}

}  // namespace

PointsByRoot sort_points_by_root(const PointCloud& cloud, const VoxelMapOptions& options) {
  if (!cloud.origin.allFinite()) throw Error("the origin of the cloud is not finite");
  if (cloud.size() >= no_voxel) {
    throw Error(fmt::format("a voxel map holds fewer than {} points, the cloud has {}", no_voxel, cloud.size()));
  }
  const VoxelGrid grid(cloud.origin, options.root_size_m, options.leaf_size_m);
  const size_t chunk_size = std::max(min_chunk_size, (cloud.size() + max_num_chunks - 1) / max_num_chunks);
  std::vector<Chunk> chunks((cloud.size() + chunk_size - 1) / chunk_size);
  const Buffer<uint32_t> roots_of_points = make_buffer<uint32_t>(cloud.size());
  parallel_for_chunks(cloud.size(), chunk_size, [&](size_t begin, size_t end) {
    Chunk& chunk = chunks[begin / chunk_size];
    chunk.beyond_limit =
        count_roots({&cloud.positions[begin], end - begin}, grid, &chunk.roots, &roots_of_points[begin]);
    if (chunk.beyond_limit) *chunk.beyond_limit += begin;
    chunk.roots.finish();
  });
  throw_if_beyond_limit(cloud, options, chunks);

  PointsByRoot sorted;
  place_chunks(&chunks, &sorted);
  sorted.num_points = sorted.points_begin.back();
  sorted.positions = make_buffer<Eigen::Vector3f>(sorted.num_points);
  sorted.input_indices = make_buffer<uint32_t>(sorted.num_points);
  parallel_for_chunks(cloud.size(), chunk_size, [&](size_t begin, size_t end) {
    uint32_t* next = chunks[begin / chunk_size].roots.counts.data();
    for (size_t i = begin; i < end; ++i) {
      if (roots_of_points[i] == no_voxel) continue;
      const uint32_t place = next[roots_of_points[i]]++;
      sorted.positions[place] = cloud.positions[i];
      sorted.input_indices[place] = static_cast<uint32_t>(i);
    }
  });
  return sorted;
}

}  // namespace cpplus
