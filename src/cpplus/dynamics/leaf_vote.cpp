#include "cpplus/dynamics/leaf_vote.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/leaf_surfaces.h"
#include "cpplus/dynamics/near_nodes.h"
#include "cpplus/dynamics/region_hits.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;
constexpr uint32_t kMinVoters = 2;

constexpr size_t kHitClasses = 8;

/// 1 hit, 2 to 3, 4 to 7 and so on.
size_t hit_class(uint32_t num_hits) { return std::min(kHitClasses, static_cast<size_t>(std::bit_width(num_hits))) - 1; }

/// Leaves, as the first look labelled them.
struct Votes {
  uint32_t dynamic_leaves = 0;
  std::array<uint32_t, kHitClasses> static_leaves{};  // by hit_class()

  void add(uint8_t label, uint32_t num_hits) {
    dynamic_leaves += label;
    if (label == 0) ++static_leaves[hit_class(num_hits)];
  }
  void add(const Votes& other) {
    dynamic_leaves += other.dynamic_leaves;
    for (size_t k = 0; k < kHitClasses; ++k) static_leaves[k] += other.static_leaves[k];
  }
  uint32_t static_up_to(size_t last_class) const {
    return std::accumulate(static_leaves.begin(), static_leaves.begin() + static_cast<std::ptrdiff_t>(last_class) + 1,
                           0u);
  }
};

/// What the leaves around say of one leaf, which is among them. Those that far more scans hit than a static one are
/// something else, such as the ground below it, and have no say.
uint8_t revised(uint8_t label, uint32_t num_hits, uint32_t num_through, const Votes& around,
                const DynamicsOptions& options) {
  const uint32_t num_dynamic = around.dynamic_leaves - label;
  const size_t last_class = label == 0 ? hit_class(num_hits) : kHitClasses - 1;
  const uint32_t num_voters = num_dynamic + around.static_up_to(last_class) - (label == 0 ? 1 : 0);
  const double share = num_voters > 0 ? static_cast<double>(num_dynamic) / num_voters : 0.0;
  if (label == 0) return num_voters >= kMinVoters && share >= options.fill_share ? 1 : 0;
  const bool is_sure = num_through >= static_cast<uint32_t>(options.sure_scans);
  return is_sure || share >= options.keep_share ? 1 : 0;
}

}  // namespace

uint32_t sufficient_scans(uint32_t num_hits, size_t num_scans, const DynamicsOptions& options) {
  const double of_leaf = options.min_share * num_hits;
  const double of_region =
      options.region_share * static_cast<double>(num_scans);  // all of them may hit something there
  return std::max(static_cast<uint32_t>(options.sure_scans),
                  static_cast<uint32_t>(std::ceil(std::max(of_leaf, of_region))));
}

std::vector<uint8_t> vote_on_leaves(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                    const std::vector<uint32_t>& num_through, const DynamicsOptions& options) {
  std::vector<uint8_t> first(num_through.size());
  for (size_t leaf = 0; leaf < first.size(); ++leaf) {
    first[leaf] = num_through[leaf] > 0 && num_through[leaf] >= options.min_share * surfaces.num_scans[leaf] ? 1 : 0;
  }
  const std::vector<uint32_t> region_hits = count_region_hits(map, scans, surfaces, first);
  for (size_t leaf = 0; leaf < first.size(); ++leaf) {
    if (num_through[leaf] < options.region_share * region_hits[leaf]) first[leaf] = 0;
  }
  return vote_with_neighbors(map, first, surfaces.num_scans, num_through, options);
}

std::vector<uint8_t> vote_with_neighbors(const VoxelMap& map, const std::vector<uint8_t>& first,
                                         const std::vector<uint32_t>& num_hits,
                                         const std::vector<uint32_t>& num_through, const DynamicsOptions& options) {
  const int layer = std::max(0, map.leaf_layer() - 1);
  std::vector<Votes> votes(map.num_nodes(layer));
  const auto over_nodes = [&](const std::function<void(uint32_t)>& visit) {
    parallel_for_chunks(votes.size(), kNodesPerTask, [&](size_t begin, size_t end) {
      for (auto node = static_cast<uint32_t>(begin); node < end; ++node) visit(node);
    });
  };
  over_nodes([&](uint32_t node) {
    const NodeRange leaves = leaves_of(map, layer, node);
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) votes[node].add(first[leaf], num_hits[leaf]);
  });
  // Only around dynamic leaves can there be any: most nodes need not be looked at.
  std::vector<uint8_t> has_dynamic(votes.size());
  for (size_t node = 0; node < votes.size(); ++node) has_dynamic[node] = votes[node].dynamic_leaves > 0 ? 1 : 0;
  const std::vector<uint8_t> is_near_dynamic = with_nodes_around(map, layer, has_dynamic);
  std::vector<uint8_t> labels(first.size(), 0);
  over_nodes([&](uint32_t node) {
    if (is_near_dynamic[node] == 0) return;
    Votes around = votes[node];
    std::vector<uint32_t> neighbors;
    map.neighbors(layer, node, false, &neighbors);
    for (const uint32_t neighbor : neighbors) around.add(votes[neighbor]);
    const NodeRange leaves = leaves_of(map, layer, node);
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      labels[leaf] = revised(first[leaf], num_hits[leaf], num_through[leaf], around, options);
    }
  });
  return labels;
}

}  // namespace cpplus
