#include "cpplus/features/leaf_neighbors.h"

#include "cpplus/core/parallel.h"

namespace cpplus {

LeafNeighbors::LeafNeighbors(const VoxelMap& map) {
  constexpr size_t kGrain = 4096;
  const uint32_t num_leaves = map.num_nodes(map.leaf_layer());
  std::vector<std::vector<uint32_t>> chunks((num_leaves + kGrain - 1) / kGrain);
  begin_.assign(num_leaves + 1, 0);
  parallel_for_chunks(num_leaves, kGrain, [&](size_t begin, size_t end) {
    std::vector<uint32_t> found;
    std::vector<uint32_t>& all = chunks[begin / kGrain];
    for (size_t leaf = begin; leaf < end; ++leaf) {
      map.neighbors(map.leaf_layer(), static_cast<uint32_t>(leaf), false, &found);
      begin_[leaf + 1] = static_cast<uint32_t>(found.size());
      all.insert(all.end(), found.begin(), found.end());
    }
  });
  for (uint32_t leaf = 0; leaf < num_leaves; ++leaf) begin_[leaf + 1] += begin_[leaf];
  neighbors_.reserve(begin_[num_leaves]);
  for (const auto& chunk : chunks) neighbors_.insert(neighbors_.end(), chunk.begin(), chunk.end());
}

}  // namespace cpplus
