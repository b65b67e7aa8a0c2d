#include "cpplus/dynamics/near_nodes.h"

#include <algorithm>
#include <atomic>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;

}  // namespace

bool has_marked_leaf(const VoxelMap& map, int layer, uint32_t node, const std::vector<uint8_t>& marked) {
  const NodeRange leaves = leaves_of(map, layer, node);
  return std::any_of(marked.begin() + leaves.begin, marked.begin() + leaves.end,
                     [](uint8_t mark) { return mark != 0; });
}

std::vector<uint8_t> with_nodes_around(const VoxelMap& map, int layer, const std::vector<uint8_t>& marked) {
  std::vector<uint8_t> around(marked.size(), 0);
  parallel_for_chunks(marked.size(), kNodesPerTask, [&](size_t begin, size_t end) {
    std::vector<uint32_t> nodes;
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      if (marked[node] == 0) continue;
      map.neighbors(layer, node, false, &nodes);
      nodes.push_back(node);
      for (const uint32_t near : nodes) std::atomic_ref(around[near]).store(1, std::memory_order_relaxed);
    }
  });
  return around;
}

std::vector<uint8_t> nodes_near_dynamic(const VoxelMap& map, int layer, const std::vector<uint8_t>& leaf_labels) {
  std::vector<uint8_t> has_dynamic(map.num_nodes(layer));
  parallel_for_chunks(has_dynamic.size(), kNodesPerTask, [&](size_t begin, size_t end) {
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      has_dynamic[node] = has_marked_leaf(map, layer, node, leaf_labels) ? 1 : 0;
    }
  });
  return with_nodes_around(map, layer, has_dynamic);
}

}  // namespace cpplus
