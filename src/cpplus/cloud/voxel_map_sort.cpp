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
  /// Index of the root of `key` in this chunk; counts the point.
  uint32_t add(const Eigen::Vector3i& key) {
    // Scans come in the order of the beam: most points share the root of the point before.
    if (keys_.empty() || key != keys_[last_]) last_ = find_or_insert(key);
    ++counts_[last_];
    return last_;
  }
  const std::vector<Eigen::Vector3i>& keys() const { return keys_; }
  /// Number of points a root; later the position where its next point goes.
  std::vector<uint32_t>& counts() { return counts_; }

 private:
  uint32_t find_or_insert(const Eigen::Vector3i& key) {
    const size_t slot = probe_key_table(table_, keys_, key);
    if (table_[slot] != no_voxel) return table_[slot];
    const uint32_t root = static_cast<uint32_t>(keys_.size());
    table_[slot] = root;
    keys_.push_back(key);
    counts_.push_back(0);
    if (2 * keys_.size() > table_.size()) table_ = make_key_table(keys_, 2 * table_.size());
    return root;
  }

  std::vector<Eigen::Vector3i> keys_;
  std::vector<uint32_t> counts_;
  std::vector<uint32_t> table_ = std::vector<uint32_t>(64, no_voxel);
  uint32_t last_ = 0;
};

struct Chunk {
  ChunkRoots roots;
  size_t first_beyond_limit = SIZE_MAX;
};

void count_chunk(const PointCloud& cloud, const VoxelGrid& grid, size_t begin, size_t end, Chunk* chunk,
                 uint32_t* roots_of_points) {
  for (size_t i = begin; i < end; ++i) {
    roots_of_points[i] = no_voxel;
    const Eigen::Vector3f& position = cloud.positions[i];
    if (!std::isfinite(position.x()) || !std::isfinite(position.y()) || !std::isfinite(position.z())) continue;
    const Eigen::Vector3d scaled = grid.scaled(position);
    if (!VoxelGrid::within_limits(scaled)) {
      chunk->first_beyond_limit = i;
      return;
    }
    roots_of_points[i] = chunk->roots.add(shift_down(VoxelGrid::cell_of(scaled), grid.bits));
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
    for (const Eigen::Vector3i& key : chunk.roots.keys()) all.add(key);
  }
  keys = all.keys();
  std::sort(keys.begin(), keys.end(), key_less);
  const std::vector<uint32_t> table = make_key_table(keys, 2 * keys.size());

  std::vector<uint32_t>& begin = sorted->points_begin;
  begin.assign(keys.size() + 1, 0);
  std::vector<std::vector<uint32_t>> root_of_chunk_root(chunks->size());
  for (size_t c = 0; c < chunks->size(); ++c) {
    ChunkRoots& roots = (*chunks)[c].roots;
    for (size_t r = 0; r < roots.keys().size(); ++r) {
      const uint32_t root = table[probe_key_table(table, keys, roots.keys()[r])];
      root_of_chunk_root[c].push_back(root);
      begin[root + 1] += roots.counts()[r];
    }
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
  for (size_t c = 0; c < chunks->size(); ++c) {
    std::vector<uint32_t>& counts = (*chunks)[c].roots.counts();
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
  const auto roots_of_points = std::make_unique_for_overwrite<uint32_t[]>(cloud.size());
  parallel_for_chunks(cloud.size(), chunk_size, [&](size_t begin, size_t end) {
    count_chunk(cloud, grid, begin, end, &chunks[begin / chunk_size], roots_of_points.get());
  });
  throw_if_beyond_limit(cloud, options, chunks);

  PointsByRoot sorted;
  place_chunks(&chunks, &sorted);
  sorted.num_points = sorted.points_begin.back();
  sorted.positions = std::make_unique_for_overwrite<Eigen::Vector3f[]>(sorted.num_points);
  sorted.input_indices = std::make_unique_for_overwrite<uint32_t[]>(sorted.num_points);
  parallel_for_chunks(cloud.size(), chunk_size, [&](size_t begin, size_t end) {
    uint32_t* next = chunks[begin / chunk_size].roots.counts().data();
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
