#include "cpplus/dynamics/region_hits.h"

#include <algorithm>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/near_nodes.h"
#include "cpplus/dynamics/scan_hits.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;

/// Collects the scans that hit some nodes.
class ScanCollector {
 public:
  ScanCollector(const VoxelMap& map, const ScanOfPoint& scan_of_point, size_t num_scans, const LeafSurfaces& surfaces)
      : map_(map), scan_of_point_(scan_of_point), surfaces_(surfaces), is_in_(num_scans, 0) {}

  uint32_t count() const { return static_cast<uint32_t>(members_.size()); }

  void clear() {
    for (const uint32_t scan : members_) is_in_[scan] = 0;
    members_.clear();
  }

  void add_leaves_off_planes(const NodeRange& leaves) {
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      if (surfaces_.normals[leaf].isZero(0.0f)) add(leaf);
    }
  }

 private:
  void add(uint32_t leaf) {
    for_each_scan_of_leaf(map_, scan_of_point_, leaf, [&](uint32_t scan, uint32_t) {
      if (is_in_[scan] == 0) members_.push_back(scan);
      is_in_[scan] = 1;
    });
  }

  const VoxelMap& map_;
  const ScanOfPoint& scan_of_point_;
  const LeafSurfaces& surfaces_;
  std::vector<uint8_t> is_in_;
  std::vector<uint32_t> members_;
};

}  // namespace

std::vector<uint32_t> count_region_hits(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                        const std::vector<uint8_t>& is_candidate) {
  const int layer = std::max(0, map.leaf_layer() - 1);
  const ScanOfPoint scan_of_point(scans);
  std::vector<uint32_t> counts(is_candidate.size(), 0);
  parallel_for_chunks(map.num_nodes(layer), kNodesPerTask, [&](size_t begin, size_t end) {
    ScanCollector around(map, scan_of_point, scans.num_scans(), surfaces);
    std::vector<uint32_t> neighbors;
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      const NodeRange leaves = leaves_of(map, layer, node);
      if (!has_marked_leaf(map, layer, node, is_candidate)) continue;
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
