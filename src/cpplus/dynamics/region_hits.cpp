#include "cpplus/dynamics/region_hits.h"

#include <algorithm>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;

/// Collects the scans that hit some nodes.
class ScanCollector {
 public:
  ScanCollector(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces)
      : map_(map), scans_(scans), surfaces_(surfaces), is_in_(scans.num_scans(), 0) {}

  uint32_t count() const { return static_cast<uint32_t>(members_.size()); }

  void clear() {
    for (const size_t scan : members_) is_in_[scan] = 0;
    members_.clear();
  }

  void add_leaves_off_planes(const LeafRange& leaves) {
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      if (surfaces_.normals[leaf].isZero(0.0f)) add(leaf);
    }
  }

 private:
  /// The points of a leaf are in the order of the scans.
  void add(uint32_t leaf) {
    size_t scan_end = 0;
    for (uint32_t i = map_.points_begin(map_.leaf_layer(), leaf); i < map_.points_end(map_.leaf_layer(), leaf); ++i) {
      const uint32_t point = map_.input_index(i);
      if (point < scan_end) continue;
      const auto next = std::upper_bound(scans_.first_point.begin(), scans_.first_point.end(), point);
      scan_end = *next;
      const auto scan = static_cast<size_t>(next - scans_.first_point.begin()) - 1;
      if (is_in_[scan] == 0) members_.push_back(scan);
      is_in_[scan] = 1;
    }
  }

  const VoxelMap& map_;
  const ScanSet& scans_;
  const LeafSurfaces& surfaces_;
  std::vector<uint8_t> is_in_;
  std::vector<size_t> members_;
};

}  // namespace

std::vector<uint32_t> count_region_hits(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                        const std::vector<uint8_t>& is_candidate) {
  const int layer = std::max(0, map.leaf_layer() - 1);
  std::vector<uint32_t> counts(is_candidate.size(), 0);
  parallel_for_chunks(map.num_nodes(layer), kNodesPerTask, [&](size_t begin, size_t end) {
    ScanCollector around(map, scans, surfaces);
    std::vector<uint32_t> neighbors;
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      const LeafRange leaves = leaves_of(map, layer, node);
      const auto is_any = [&](const std::vector<uint8_t>& is) {
        return std::any_of(is.begin() + leaves.begin, is.begin() + leaves.end,
                           [](uint8_t value) { return value != 0; });
      };
      if (!is_any(is_candidate)) continue;
      around.clear();
      around.add_leaves_off_planes(leaves);
      map.neighbors(layer, node, false, &neighbors);
      for (const uint32_t neighbor : neighbors) around.add_leaves_off_planes(leaves_of(map, layer, neighbor));
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        if (is_candidate[leaf] != 0) counts[leaf] = around.count();
      }
    }
  });
  return counts;
}

}  // namespace cpplus
