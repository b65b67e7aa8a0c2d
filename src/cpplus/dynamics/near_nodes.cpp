#include "cpplus/dynamics/near_nodes.h"

#include <atomic>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;

}  // namespace

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

}  // namespace cpplus
