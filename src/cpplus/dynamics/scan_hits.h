#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// Which scan a point of a set belongs to, in constant time where scans are not far smaller than a block.
class ScanOfPoint {
 public:
  explicit ScanOfPoint(const ScanSet& scans);

  /// `point` is below scans.first_point.back().
  uint32_t operator()(size_t point) const {
    uint32_t scan = scan_of_block_[point / kBlock];
    while (first_point_[scan + 1] <= point) ++scan;
    return scan;
  }

 private:
  static constexpr size_t kBlock = 1024;

  std::span<const size_t> first_point_;
  std::vector<uint32_t> scan_of_block_;  // of the block's first point
};

/// Calls visit(scan, i) for each scan that hits a leaf, ascending, with the first of its points there in map order: the
/// points of a leaf keep the order of the scans, so its set of scan identifiers need not be stored.
template <typename Visit>
void for_each_scan_of_leaf(const VoxelMap& map, const ScanOfPoint& scan_of_point, uint32_t leaf, const Visit& visit) {
  const uint32_t end = map.points_end(map.leaf_layer(), leaf);
  uint32_t before = no_voxel;
  for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < end; ++i) {
    const uint32_t scan = scan_of_point(map.input_index(i));
    if (scan != before) visit(scan, i);
    before = scan;
  }
}

/// A leaf that a scan hits, and the first of the scan's points in it.
struct LeafHit {
  uint32_t leaf = 0;
  uint32_t point = 0;  // in map order
};

/// The leaves that each scan hits, ascending.
struct ScanHits {
  std::vector<LeafHit> hits;
  std::vector<size_t> first_hit;  // scans + 1

  std::span<const LeafHit> of(size_t scan) const {
    return std::span(hits).subspan(first_hit[scan], first_hit[scan + 1] - first_hit[scan]);
  }
};

/// `map` is the voxel map of scans.points.
ScanHits find_scan_hits(const VoxelMap& map, const ScanSet& scans);

}  // namespace cpplus
