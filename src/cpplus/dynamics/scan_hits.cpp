#include "cpplus/dynamics/scan_hits.h"

#include <algorithm>

#include "cpplus/core/parallel.h"

namespace cpplus {

ScanOfPoint::ScanOfPoint(const ScanSet& scans) : first_point_(scans.first_point) {
  uint32_t scan = 0;
  for (size_t point = 0; point < first_point_.back(); point += kBlock) {
    while (first_point_[scan + 1] <= point) ++scan;
    scan_of_block_.push_back(scan);
  }
}

ScanHits find_scan_hits(const VoxelMap& map, const ScanSet& scans) {
  // A counting sort by scan. Few chunks, because each has its own counters.
  constexpr size_t kMinLeavesPerChunk = 8192;
  constexpr size_t kMaxChunks = 64;
  const ScanOfPoint scan_of_point(scans);
  const size_t num_leaves = map.num_nodes(map.leaf_layer());
  const size_t grain = std::max(kMinLeavesPerChunk, (num_leaves + kMaxChunks - 1) / kMaxChunks);
  std::vector<std::vector<size_t>> next((num_leaves + grain - 1) / grain);  // by chunk, then scan
  const auto over_hits = [&](const auto& visit) {
    parallel_for_chunks(num_leaves, grain, [&](size_t begin, size_t end) {
      std::vector<size_t>& counters = next[begin / grain];
      for (auto leaf = static_cast<uint32_t>(begin); leaf < end; ++leaf) {
        for_each_scan_of_leaf(map, scan_of_point, leaf, [&](uint32_t scan, uint32_t i) {
          visit(&counters[scan], LeafHit{leaf, i});
        });
      }
    });
  };
  for (std::vector<size_t>& counters : next) counters.assign(scans.num_scans(), 0);
  over_hits([](size_t* counter, const LeafHit&) { ++*counter; });

  ScanHits result;
  size_t num_hits = 0;
  for (size_t scan = 0; scan < scans.num_scans(); ++scan) {
    result.first_hit.push_back(num_hits);
    for (std::vector<size_t>& counters : next) {
      const size_t count = counters[scan];
      counters[scan] = num_hits;
      num_hits += count;
    }
  }
  result.first_hit.push_back(num_hits);
  result.hits.resize(num_hits);
  over_hits([&](size_t* counter, const LeafHit& hit) { result.hits[(*counter)++] = hit; });
  return result;
}

}  // namespace cpplus
