#include "cpplus/cloud/voxel_map.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "cpplus/cloud/voxel_map_build.h"
#include "cpplus/core/options.h"

namespace cpplus {
namespace {

/// Nodes of one layer that meet a box of at most 2 x 2 x 2 voxels, no_voxel where there is none.
struct Block {
  Eigen::Vector3i low;
  std::array<uint32_t, 8> nodes;

  size_t index(const Eigen::Vector3i& voxel) const {
    const Eigen::Vector3i offset = voxel - low;
    return static_cast<size_t>(offset.x() + 2 * offset.y() + 4 * offset.z());
  }
  uint32_t at(const Eigen::Vector3i& voxel) const { return nodes[index(voxel)]; }
};

template <typename Body>
void for_each_voxel(const Eigen::Vector3i& low, const Eigen::Vector3i& high, const Body& body) {
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) body(Eigen::Vector3i(x, y, z));
    }
  }
}

}  // namespace

void VoxelMapOptions::validate() const {
  check_option(root_size_m > 0 && std::isfinite(root_size_m), "root_size_m", "(0, inf)", root_size_m);
  check_option(leaf_size_m > 0 && leaf_size_m <= root_size_m, "leaf_size_m", "(0, root_size_m]", leaf_size_m);
  const double bits = std::log2(root_size_m / leaf_size_m);
  check_option(std::abs(bits - std::round(bits)) < 1e-9 && bits < max_leaf_bits + 0.5, "root_size_m / leaf_size_m",
               "{1, 2, 4, ..., 1024}", root_size_m / leaf_size_m);
}

VoxelMap::VoxelMap(const PointCloud& cloud, const VoxelMapOptions& options) : options_(options) {
  options.validate();
  grid_ = VoxelGrid(cloud.origin, options.root_size_m, options.leaf_size_m);
  arrays_ = build_voxel_map(cloud, options);
}

VoxelMap::VoxelMap(const Eigen::Vector3d& origin, const VoxelMapOptions& options, VoxelMapArrays arrays)
    : options_(options), grid_(origin, options.root_size_m, options.leaf_size_m), arrays_(std::move(arrays)) {
  options.validate();
}

size_t VoxelMap::memory_bytes() const {
  size_t bytes = arrays_.positions.size_bytes() + arrays_.input_indices.size_bytes() + arrays_.root_keys.size_bytes() +
                 arrays_.root_table.size_bytes();
  for (const VoxelMapLayer& l : arrays_.layers) {
    bytes += l.first.size_bytes() + l.child_mask.size_bytes() + l.moments_mask.size_bytes() +
             l.moments_rank.size_bytes() + l.moments.size_bytes();
  }
  return bytes;
}

uint32_t VoxelMap::parent(int layer, uint32_t node) const { return *find(layer - 1, shift_down(key(layer, node), 1)); }

VoxelStatistics VoxelMap::statistics(int layer, uint32_t node) const {
  const uint32_t begin = points_begin(layer, node);
  const uint32_t end = points_end(layer, node);
  VoxelStatistics s;
  s.count = end - begin;
  const VoxelMapLayer& nodes = this->layer(layer);
  const uint64_t bit = uint64_t{1} << (node % 64);
  if (layer < leaf_layer() && (nodes.moments_mask[node / 64] & bit) != 0) {
    const int rank = std::popcount(nodes.moments_mask[node / 64] & (bit - 1));
    const VoxelMoments& m = nodes.moments[nodes.moments_rank[node / 64] + static_cast<uint32_t>(rank)];
    const Eigen::Vector3i root_key = shift_down(key(layer, node), layer);
    s.mean = (root_key.cast<double>().array() + 0.5) * options_.root_size_m + m.mean.cast<double>().array();
    const std::array<float, 6>& c = m.covariance;
    s.covariance << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
    return s;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // relative to the first point
  const Eigen::Vector3d center = arrays_.positions[begin].cast<double>();
  for (uint32_t i = begin; i < end; ++i) sum += arrays_.positions[i].cast<double>() - center;
  const Eigen::Vector3d mean = center + sum / static_cast<double>(s.count);
  for (uint32_t i = begin; i < end; ++i) {
    const Eigen::Vector3d d = arrays_.positions[i].cast<double>() - mean;
    s.covariance += d * d.transpose();
  }
  s.covariance /= static_cast<double>(s.count);
  s.mean = grid_.origin + mean;
  return s;
}

Eigen::Vector3i VoxelMap::key(int layer, uint32_t node) const {
  if (layer == 0) return arrays_.root_keys[node];
  // Any point of the node knows its key, which need not be stored.
  return key_of(layer, point(points_begin(layer, node)));
}

Eigen::Vector3i VoxelMap::key_of(int layer, const Eigen::Vector3d& x_in_map) const {
  // From the leaf's key, so that rounding at a border is the same in every layer.
  return shift_down(grid_.cell_of(x_in_map), leaf_layer() - layer);
}

uint32_t VoxelMap::find_root(const Eigen::Vector3i& key) const {
  return arrays_.root_table[probe_key_table(arrays_.root_table, arrays_.root_keys, key)];
}

std::optional<uint32_t> VoxelMap::find(int layer, const Eigen::Vector3i& key) const {
  uint32_t node = find_root(shift_down(key, layer));
  for (int l = 0; l < layer && node != no_voxel; ++l) {
    node = child_in_octant(l, node, octant_of(shift_down(key, layer - l - 1)));
  }
  if (node == no_voxel) return std::nullopt;
  return node;
}

std::optional<VoxelNode> VoxelMap::find_lowest(const Eigen::Vector3i& cell) const {
  VoxelNode lowest{0, find_root(shift_down(cell, leaf_layer()))};
  if (lowest.index == no_voxel) return std::nullopt;
  while (lowest.layer < leaf_layer()) {
    const int octant = octant_of(shift_down(cell, leaf_layer() - lowest.layer - 1));
    const uint32_t child = child_in_octant(lowest.layer, lowest.index, octant);
    if (child == no_voxel) break;
    lowest = {lowest.layer + 1, child};
  }
  return lowest;
}

void VoxelMap::neighbors(int layer, uint32_t node, bool faces_only, std::vector<uint32_t>* nodes) const {
  nodes->clear();
  // The 3 x 3 x 3 voxels around a node have at most 2 x 2 x 2 ancestors in any layer above: come down through these.
  const auto node_at = [&](int l, const Block& above, const Eigen::Vector3i& voxel) {
    if (l == 0) return find_root(voxel);
    const uint32_t up = above.at(shift_down(voxel, 1));
    return up == no_voxel ? no_voxel : child_in_octant(l - 1, up, octant_of(voxel));
  };
  const Eigen::Vector3i center = key(layer, node);
  const Eigen::Vector3i low = center.array() - 1;
  const Eigen::Vector3i high = center.array() + 1;
  Block block{Eigen::Vector3i::Zero(), {}};
  for (int l = 0; l < layer; ++l) {
    Block below{shift_down(low, layer - l), {}};
    for_each_voxel(below.low, shift_down(high, layer - l),
                   [&](const Eigen::Vector3i& voxel) { below.nodes[below.index(voxel)] = node_at(l, block, voxel); });
    block = below;
  }
  for_each_voxel(low, high, [&](const Eigen::Vector3i& voxel) {
    const int distance = (voxel - center).cwiseAbs().sum();
    if (distance == 0 || (faces_only && distance > 1)) return;
    const uint32_t found = node_at(layer, block, voxel);
    if (found != no_voxel) nodes->push_back(found);
  });
  std::sort(nodes->begin(), nodes->end());
}

std::vector<uint32_t> VoxelMap::roots_in_radius(const Eigen::Vector3d& x_in_map, double radius_m) const {
  std::vector<uint32_t> roots;
  // One more below: a root whose upper side just touches counts.
  const Eigen::Vector3i low = key_of(0, x_in_map.array() - radius_m).array() - 1;
  const Eigen::Vector3i high = key_of(0, x_in_map.array() + radius_m);
  // Roots ascend by x, then y, then z: each x has its wanted range of y and z in one run.
  auto root = std::lower_bound(arrays_.root_keys.begin(), arrays_.root_keys.end(), low, key_less);
  while (root != arrays_.root_keys.end() && root->x() <= high.x()) {
    const Eigen::Vector3i slab_low(root->x(), low.y(), low.z());
    const Eigen::Vector3i slab_high(root->x(), high.y(), high.z());
    root = std::lower_bound(root, arrays_.root_keys.end(), slab_low, key_less);
    for (; root != arrays_.root_keys.end() && !key_less(slab_high, *root); ++root) {
      const Eigen::Vector3d center = (root->cast<double>().array() + 0.5) * options_.root_size_m;
      const Eigen::Vector3d to_box = ((x_in_map - center).cwiseAbs().array() - 0.5 * options_.root_size_m).max(0.0);
      if (to_box.squaredNorm() > radius_m * radius_m) continue;
      roots.push_back(static_cast<uint32_t>(root - arrays_.root_keys.begin()));
    }
    const Eigen::Vector3i next_slab(slab_low.x() + 1, low.y(), low.z());
    root = std::lower_bound(root, arrays_.root_keys.end(), next_slab, key_less);
  }
  return roots;
}

std::vector<uint32_t> VoxelMap::roots_in_frustum(const Eigen::Vector3d& apex_in_map, const Eigen::Vector3d& axis_in_map,
                                                 double half_angle, double radius_m) const {
  std::vector<uint32_t> roots = roots_in_radius(apex_in_map, radius_m);
  const double sphere_radius = 0.5 * std::sqrt(3.0) * options_.root_size_m;
  std::erase_if(roots, [&](uint32_t root) {
    const Eigen::Vector3d to_center = center(0, root) - apex_in_map;
    const double distance = to_center.norm();
    if (distance <= sphere_radius) return false;
    const double angle = std::acos(std::clamp(to_center.dot(axis_in_map) / distance, -1.0, 1.0));
    return angle > half_angle + std::asin(sphere_radius / distance);
  });
  return roots;
}

}  // namespace cpplus
