#include "cpplus/dynamics/fill_by_scan.h"

#include <algorithm>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/near_nodes.h"
#include "cpplus/dynamics/scan_hits.h"

namespace cpplus {
namespace {

constexpr int kLayersUp = 3;
constexpr size_t kNodesPerTask = 64;
constexpr uint32_t kMinDynamic = 2;

/// Leaves around a node, by the scans that hit them.
class ScanVotes {
 public:
  explicit ScanVotes(size_t num_scans) : votes_(num_scans) {}

  void clear() {
    for (const uint32_t scan : voters_) votes_[scan] = {};
    voters_.clear();
  }
  void add(uint32_t scan, uint8_t label) {
    Vote& vote = votes_[scan];
    if (vote.num_leaves == 0) voters_.push_back(scan);
    ++vote.num_leaves;
    vote.num_dynamic += label;
  }
  bool is_dynamic(uint32_t scan, double min_share) const {
    const Vote& vote = votes_[scan];
    return vote.num_dynamic >= kMinDynamic && vote.num_dynamic >= min_share * vote.num_leaves;
  }

 private:
  struct Vote {
    uint32_t num_leaves = 0;
    uint32_t num_dynamic = 0;
  };

  std::vector<Vote> votes_;       // by scan
  std::vector<uint32_t> voters_;  // scans that have a vote
};

class ScanFiller {
 public:
  ScanFiller(const VoxelMap& map, const ScanSet& scans, const std::vector<uint32_t>& num_scans,
             const std::vector<uint8_t>& labels, double fill_share, int layer)
      : map_(map),
        num_all_scans_(scans.num_scans()),
        scan_of_point_(scans),
        num_scans_(num_scans),
        labels_(labels),
        fill_share_(fill_share),
        layer_(layer) {}

  /// Labels what is filled in the nodes [begin, end) that are marked.
  void fill(uint32_t begin, uint32_t end, const std::vector<uint8_t>& is_marked, std::vector<uint8_t>* filled) const {
    ScanVotes votes(num_all_scans_);
    std::vector<uint32_t> around;
    for (uint32_t node = begin; node < end; ++node) {
      if (is_marked[node] == 0) continue;
      map_.neighbors(layer_, node, false, &around);
      around.push_back(node);
      const uint32_t max_scans = 2 * most_scans_of_dynamic(around);
      if (!has_static(node, max_scans)) continue;
      gather(around, max_scans, &votes);
      const NodeRange leaves = leaves_of(map_, layer_, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        if (is_static(leaf, max_scans) && all_scans_say_dynamic(leaf, votes)) (*filled)[leaf] = 1;
      }
    }
  }

 private:
  bool is_static(uint32_t leaf, uint32_t max_scans) const {
    return labels_[leaf] == 0 && num_scans_[leaf] <= max_scans;
  }

  bool has_static(uint32_t node, uint32_t max_scans) const {
    const NodeRange leaves = leaves_of(map_, layer_, node);
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      if (is_static(leaf, max_scans)) return true;
    }
    return false;
  }

  uint32_t most_scans_of_dynamic(const std::vector<uint32_t>& nodes) const {
    uint32_t most = 0;
    for (const uint32_t node : nodes) {
      const NodeRange leaves = leaves_of(map_, layer_, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        if (labels_[leaf] != 0) most = std::max(most, num_scans_[leaf]);
      }
    }
    return most;
  }

  void gather(const std::vector<uint32_t>& nodes, uint32_t max_scans, ScanVotes* votes) const {
    votes->clear();
    for (const uint32_t node : nodes) {
      const NodeRange leaves = leaves_of(map_, layer_, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        if (labels_[leaf] == 0 && num_scans_[leaf] > max_scans) continue;
        for_each_scan_of_leaf(map_, scan_of_point_, leaf,
                              [&](uint32_t scan, uint32_t) { votes->add(scan, labels_[leaf]); });
      }
    }
  }

  bool all_scans_say_dynamic(uint32_t leaf, const ScanVotes& votes) const {
    bool all = true;
    for_each_scan_of_leaf(map_, scan_of_point_, leaf,
                          [&](uint32_t scan, uint32_t) { all = all && votes.is_dynamic(scan, fill_share_); });
    return all;
  }

  const VoxelMap& map_;
  const size_t num_all_scans_;
  const ScanOfPoint scan_of_point_;
  const std::vector<uint32_t>& num_scans_;
  const std::vector<uint8_t>& labels_;
  const double fill_share_;
  const int layer_;
};

}  // namespace

std::vector<uint8_t> fill_by_scan(const VoxelMap& map, const ScanSet& scans, const std::vector<uint32_t>& num_scans,
                                  const std::vector<uint8_t>& labels, const DynamicsOptions& options) {
  const int layer = std::max(0, map.leaf_layer() - kLayersUp);
  const std::vector<uint8_t> is_near_dynamic = nodes_near_dynamic(map, layer, labels);
  const ScanFiller filler(map, scans, num_scans, labels, options.fill_share, layer);
  std::vector<uint8_t> filled = labels;
  parallel_for_chunks(map.num_nodes(layer), kNodesPerTask, [&](size_t begin, size_t end) {
    filler.fill(static_cast<uint32_t>(begin), static_cast<uint32_t>(end), is_near_dynamic, &filled);
  });
  return filled;
}

}  // namespace cpplus
