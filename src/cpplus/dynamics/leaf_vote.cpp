#include "cpplus/dynamics/leaf_vote.h"

#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/leaf_surfaces.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;
constexpr uint32_t kMinVoters = 2;

struct Votes {
  uint32_t dynamic = 0;
  uint32_t all = 0;
};

/// What the leaves around say of one leaf.
uint8_t revised(uint8_t label, uint32_t num_through, const Votes& around, const DynamicsOptions& options) {
  const double share = around.all > 0 ? static_cast<double>(around.dynamic) / around.all : 0.0;
  if (label == 0) return around.all >= kMinVoters && share >= options.fill_share ? 1 : 0;
  const bool is_sure = num_through >= static_cast<uint32_t>(options.sure_scans);
  return is_sure || share >= options.keep_share ? 1 : 0;
}

}  // namespace

uint32_t sufficient_scans(uint32_t num_hits, const DynamicsOptions& options) {
  return std::max(static_cast<uint32_t>(options.sure_scans),
                  static_cast<uint32_t>(std::ceil(options.min_share * num_hits)));
}

std::vector<uint8_t> vote_on_leaves(const VoxelMap& map, const std::vector<uint32_t>& num_hits,
                                    const std::vector<uint32_t>& num_through, const DynamicsOptions& options) {
  std::vector<uint8_t> first(num_hits.size());
  for (size_t leaf = 0; leaf < first.size(); ++leaf) {
    first[leaf] = num_through[leaf] > 0 && num_through[leaf] >= options.min_share * num_hits[leaf] ? 1 : 0;
  }
  const int layer = std::max(0, map.leaf_layer() - 1);
  std::vector<Votes> votes(map.num_nodes(layer));
  for (uint32_t node = 0; node < votes.size(); ++node) {
    const LeafRange leaves = leaves_of(map, layer, node);
    votes[node].all = leaves.end - leaves.begin;
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) votes[node].dynamic += first[leaf];
  }
  std::vector<uint8_t> labels(first.size());
  parallel_for_chunks(votes.size(), kNodesPerTask, [&](size_t begin, size_t end) {
    std::vector<uint32_t> neighbors;
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      Votes around = votes[node];
      map.neighbors(layer, node, false, &neighbors);
      for (const uint32_t neighbor : neighbors) {
        around.dynamic += votes[neighbor].dynamic;
        around.all += votes[neighbor].all;
      }
      const LeafRange leaves = leaves_of(map, layer, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        const Votes others{around.dynamic - first[leaf], around.all - 1};
        labels[leaf] = revised(first[leaf], num_through[leaf], others, options);
      }
    }
  });
  return labels;
}

}  // namespace cpplus
