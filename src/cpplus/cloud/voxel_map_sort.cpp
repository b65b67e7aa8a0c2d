#include "cpplus/cloud/voxel_map_sort.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "cpplus/cloud/voxel_map_grid.h"
#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

// Few chunks, because each has its own counters; their number must not depend on the number of threads.
constexpr size_t min_chunk_size = 1 << 16;
constexpr size_t max_num_chunks = 32;

/// The roots that a chunk of the input meets, in the order of meeting them, and how many points fall in each.
class ChunkRoots {
 public:
  /// Index of the root of `key` in this chunk; counts `count` points.
  uint32_t add(const Eigen::Vector3i& key, uint32_t count) {
    // A sparse table with the keys inside: nearly every look-up ends at the first slot, which the processor predicts.
    size_t slot = hash_key(key) >> shift_;
    while (slots_[slot].root != no_voxel && !slots_[slot].holds(key)) slot = (slot + 1) & (slots_.size() - 1);
    uint32_t root = slots_[slot].root;
    if (root == no_voxel) [[unlikely]]
      root = insert(key, slot);
    counts[root] += count;
    return root;
  }

  std::vector<Eigen::Vector3i> keys;
  std::vector<uint32_t> counts;  // points a root; later the place where its next point goes

 private:
  struct Slot {
    int32_t x = 0, y = 0, z = 0;
    uint32_t root = no_voxel;

    bool holds(const Eigen::Vector3i& key) const { return ((x ^ key.x()) | (y ^ key.y()) | (z ^ key.z())) == 0; }
  };

  uint32_t insert(const Eigen::Vector3i& key, size_t slot) {
    const uint32_t root = static_cast<uint32_t>(keys.size());
    slots_[slot] = {key.x(), key.y(), key.z(), root};
    keys.push_back(key);
    counts.push_back(0);
    if (8 * keys.size() > slots_.size()) grow();
    return root;
  }

  void grow() {
    slots_.assign(4 * slots_.size(), Slot());
    shift_ -= 2;
    for (uint32_t root = 0; root < keys.size(); ++root) {
      size_t slot = hash_key(keys[root]) >> shift_;
      while (slots_[slot].root != no_voxel) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = {keys[root].x(), keys[root].y(), keys[root].z(), root};
    }
  }

  std::vector<Slot> slots_ = std::vector<Slot>(1024);
  int shift_ = 64 - 10;  // leaves as many bits of the hash as slots_ has slots
};

struct Chunk {
  ChunkRoots roots;
  size_t first_beyond_limit = SIZE_MAX;
};

void count_chunk(const PointCloud& cloud, const VoxelGrid& grid, size_t begin, size_t end, Chunk* chunk,
                 uint32_t* roots_of_points) {
  CellBlock block(grid);
  for (size_t first = begin; first < end; first += CellBlock::max_points) {
    const size_t size = std::min(CellBlock::max_points, end - first);
    const bool all_inside = block.compute({&cloud.positions[first], size});
    for (size_t i = first; i < first + size; ++i) {
      const Eigen::Vector3i cell = block.cell(i - first);
      if (all_inside || !is_outside(cell)) {
        roots_of_points[i] = chunk->roots.add(shift_down(cell, grid.bits), 1);
        continue;
      }
      roots_of_points[i] = no_voxel;
      if (!cloud.positions[i].allFinite()) continue;
      chunk->first_beyond_limit = i;
      return;
    }
  }
}

void throw_if_beyond_limit(const PointCloud& cloud, const VoxelMapOptions& options, const std::vector<Chunk>& chunks) {
  for (const Chunk& chunk : chunks) {
    const size_t i = chunk.first_beyond_limit;
    if (i == SIZE_MAX) continue;
    const Eigen::Vector3d x = cloud.point(i);
    throw Error(
        fmt::format("point {} at ({}, {}, {}) m is outside the voxel grid: with leaf_size_m {} coordinates must "
                    "be within +-{} m",
                    i, x.x(), x.y(), x.z(), options.leaf_size_m, max_cell * options.leaf_size_m));
  }
}

/// Gathers the roots of all chunks, ascending, and turns each chunk's counts into the places of its points: root by
/// root, and inside a root chunk by chunk, which keeps the order of the input.
void place_chunks(std::vector<Chunk>* chunks, PointsByRoot* sorted) {
  std::vector<Eigen::Vector3i>& keys = sorted->root_keys;
  ChunkRoots all;
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
    const ChunkRoots& roots = (*chunks)[c].roots;
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
    count_chunk(cloud, grid, begin, end, &chunks[begin / chunk_size], roots_of_points.get());
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
