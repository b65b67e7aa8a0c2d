#include "cpplus/dynamics/leaf_vote.h"

#include <algorithm>
#include <cmath>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/region_hits.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;
constexpr uint32_t kMinNear = 2;  // one ray beside a leaf tells too little

struct LeafCount {
  uint32_t all = 0;
  uint32_t dynamic = 0;

  void add(const LeafCount& other) {
    all += other.all;
    dynamic += other.dynamic;
  }
};

}  // namespace

uint32_t sufficient_scans(uint32_t num_hits, size_t num_scans, const DynamicsOptions& options) {
  const double of_leaf = std::max(options.min_share, options.sure_share) * num_hits;
  const double of_region =
      options.region_share * static_cast<double>(num_scans);  // all of them may hit something there
  return std::max(1u, static_cast<uint32_t>(std::ceil(std::max(of_leaf, of_region))));
}

std::vector<uint8_t> vote_on_leaves(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                    const SeeThrough& seen, const DynamicsOptions& options) {
  const size_t num_leaves = surfaces.num_scans.size();
  const auto is_seen_through = [&](size_t leaf) {
    return seen.num_through[leaf] > 0 && seen.num_through[leaf] >= options.min_share * surfaces.num_scans[leaf];
  };
  const auto is_seen_near = [&](size_t leaf) { return seen.num_near[leaf] >= kMinNear; };
  std::vector<uint8_t> labels(num_leaves);
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) labels[leaf] = is_seen_through(leaf) || is_seen_near(leaf) ? 1 : 0;
  const std::vector<uint32_t> region_hits = count_region_hits(map, scans, surfaces, labels);
  std::vector<uint8_t> is_sure(num_leaves, 0);
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) {
    if (labels[leaf] == 0) continue;
    const uint32_t num_through = seen.num_through[leaf];
    const bool through = is_seen_through(leaf) && num_through >= options.region_share * region_hits[leaf];
    const bool near = is_seen_near(leaf) && seen.num_near[leaf] >= options.near_share * region_hits[leaf];
    labels[leaf] = through || near ? 1 : 0;
    is_sure[leaf] = near || num_through >= options.sure_share * surfaces.num_scans[leaf] ? 1 : 0;
  }
  return keep_with_neighbors(map, labels, is_sure, options.keep_share);
}

std::vector<uint8_t> keep_with_neighbors(const VoxelMap& map, const std::vector<uint8_t>& labels,
                                         const std::vector<uint8_t>& is_sure, double keep_share) {
  const int layer = std::max(0, map.leaf_layer() - 1);
  std::vector<LeafCount> counts(map.num_nodes(layer));
  parallel_for_chunks(counts.size(), kNodesPerTask, [&](size_t begin, size_t end) {
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      const NodeRange leaves = leaves_of(map, layer, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) counts[node].add({1, labels[leaf]});
    }
  });
  std::vector<uint8_t> kept = labels;
  parallel_for_chunks(counts.size(), kNodesPerTask, [&](size_t begin, size_t end) {
    std::vector<uint32_t> neighbors;
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      if (counts[node].dynamic == 0) continue;
      LeafCount around = counts[node];
      map.neighbors(layer, node, false, &neighbors);
      for (const uint32_t neighbor : neighbors) around.add(counts[neighbor]);
      const bool are_few = around.dynamic - 1 < keep_share * (around.all - 1);
      const NodeRange leaves = leaves_of(map, layer, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        if (are_few && is_sure[leaf] == 0) kept[leaf] = 0;
      }
    }
  });
  return kept;
}

}  // namespace cpplus
