#include "cpplus/dynamics/standing_points.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/leaf_surfaces.h"
#include "cpplus/dynamics/near_nodes.h"
#include "cpplus/dynamics/scan_hits.h"

namespace cpplus {
namespace {

constexpr size_t kNodesPerTask = 2048;

class StandingPoints {
 public:
  StandingPoints(const VoxelMap& map, const ScanSet& scans, const std::vector<uint8_t>& leaf_labels,
                 double min_height_m, std::vector<uint8_t>* labels)
      : map_(map),
        scans_(scans),
        scan_of_point_(scans),
        leaf_labels_(leaf_labels),
        layer_(std::max(0, map.leaf_layer() - 1)),
        min_height_m_(static_cast<float>(min_height_m)),
        labels_(*labels) {}

  // The voxels above the leaves that hold dynamic ones or lie beside such.
  std::vector<uint32_t> nodes_to_look_at() const {
    const std::vector<uint8_t> is_near = nodes_near_dynamic(map_, layer_, leaf_labels_);
    std::vector<uint32_t> nodes;
    for (uint32_t node = 0; node < is_near.size(); ++node) {
      if (is_near[node] != 0) nodes.push_back(node);
    }
    return nodes;
  }

  size_t label_in_node(uint32_t node) const {
    const std::vector<uint32_t> visitors = scans_of_dynamic_leaves_around(node);
    const NodeRange leaves = leaves_of(map_, layer_, node);
    size_t count = 0;
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      if (leaf_labels_[leaf] == 0) count += label_in_leaf(leaf, visitors);
    }
    return count;
  }

 private:
  size_t label_in_leaf(uint32_t leaf, const std::vector<uint32_t>& visitors) const {
    if (!is_hit_by(leaf, visitors)) return 0;
    const std::optional<SurfacePatch> surface = surface_without(leaf, visitors);
    if (!surface) return 0;
    size_t count = 0;
    for_each_point({leaf, leaf + 1}, [&](uint32_t i, uint32_t scan) {
      if (!contains(visitors, scan) || !stands_out(*surface, i, scan)) return;
      labels_[map_.input_index(i)] = 1;
      ++count;
    });
    return count;
  }

  static bool contains(const std::vector<uint32_t>& sorted, uint32_t scan) {
    return std::binary_search(sorted.begin(), sorted.end(), scan);
  }

  template <typename Visit>
  void for_each_point(const NodeRange& leaves, const Visit& visit) const {
    const uint32_t end = map_.points_begin(map_.leaf_layer(), leaves.end);
    for (uint32_t i = map_.points_begin(map_.leaf_layer(), leaves.begin); i < end; ++i) {
      visit(i, scan_of_point_(map_.input_index(i)));
    }
  }

  std::vector<uint32_t> scans_of_dynamic_leaves_around(uint32_t node) const {
    std::vector<uint32_t> nodes;
    map_.neighbors(layer_, node, false, &nodes);
    nodes.push_back(node);
    std::vector<uint32_t> scans;
    for (const uint32_t near : nodes) {
      const NodeRange leaves = leaves_of(map_, layer_, near);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        if (leaf_labels_[leaf] == 0) continue;
        for_each_scan_of_leaf(map_, scan_of_point_, leaf, [&](uint32_t scan, uint32_t) { scans.push_back(scan); });
      }
    }
    std::sort(scans.begin(), scans.end());
    scans.erase(std::unique(scans.begin(), scans.end()), scans.end());
    return scans;
  }

  bool is_hit_by(uint32_t leaf, const std::vector<uint32_t>& scans) const {
    bool hit = false;
    for_each_scan_of_leaf(map_, scan_of_point_, leaf, [&](uint32_t scan, uint32_t) { hit |= contains(scans, scan); });
    return hit;
  }

  // The surface as all but the given scans have it.
  std::optional<SurfacePatch> surface_without(uint32_t leaf, const std::vector<uint32_t>& scans) const {
    uint32_t node = leaf;
    int layer = map_.leaf_layer();
    for (int up = 1; up <= 3 && layer > 0; ++up) {
      node = map_.parent(layer, node);
      --layer;
      if (up == 1) continue;
      std::vector<Eigen::Vector3f> points;
      for_each_point(leaves_of(map_, layer, node), [&](uint32_t i, uint32_t scan) {
        if (!contains(scans, scan)) points.push_back(map_.positions()[i]);
      });
      if (const auto patch = fit_patch(points)) return patch;
    }
    return std::nullopt;
  }

  bool stands_out(const SurfacePatch& surface, uint32_t i, uint32_t scan) const {
    const Eigen::Vector3f sensor = (scans_.sensors_in_map[scan] - map_.origin()).cast<float>();
    const float side = surface.normal.dot(sensor - surface.mean) > 0.0f ? 1.0f : -1.0f;
    return side * surface.normal.dot(map_.positions()[i] - surface.mean) >= min_height_m_;
  }

  const VoxelMap& map_;
  const ScanSet& scans_;
  const ScanOfPoint scan_of_point_;
  const std::vector<uint8_t>& leaf_labels_;
  const int layer_;  // just above the leaves
  const float min_height_m_;
  std::vector<uint8_t>& labels_;
};

}  // namespace

size_t label_standing_points(const VoxelMap& map, const ScanSet& scans, const std::vector<uint8_t>& leaf_labels,
                             double min_height_m, std::vector<uint8_t>* labels) {
  const StandingPoints standing(map, scans, leaf_labels, min_height_m, labels);
  const std::vector<uint32_t> nodes = standing.nodes_to_look_at();
  std::vector<size_t> counts(nodes.size(), 0);
  parallel_for_chunks(nodes.size(), kNodesPerTask, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) counts[k] = standing.label_in_node(nodes[k]);
  });
  return std::accumulate(counts.begin(), counts.end(), size_t{0});
}

}  // namespace cpplus
