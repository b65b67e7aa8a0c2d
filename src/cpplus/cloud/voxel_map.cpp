#include "cpplus/cloud/voxel_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cpplus/core/error.h"
#include "cpplus/core/options.h"

namespace cpplus {
namespace {

int layers_of(const VoxelMapOptions& options) {
  return 1 + static_cast<int>(std::lround(std::log2(options.root_size_m / options.leaf_size_m)));
}

// x in the lowest bit of each triple, then y, z.
uint64_t morton(const Eigen::Vector3i& cell, int bits) {
  uint64_t code = 0;
  for (int b = bits - 1; b >= 0; --b) {
    for (int axis = 2; axis >= 0; --axis) code = (code << 1) | ((static_cast<uint64_t>(cell[axis]) >> b) & 1u);
  }
  return code;
}

Eigen::Vector3i morton_cell(uint64_t code, int bits) {
  Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  for (int b = 0; b < bits; ++b) {
    for (int axis = 0; axis < 3; ++axis) cell[axis] |= static_cast<int>((code >> (3 * b + axis)) & 1u) << b;
  }
  return cell;
}

bool key_less(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

int floor_div_pow2(int value, int shift) { return value >> shift; }

}  // namespace

void VoxelMapOptions::validate() const {
  check_option(root_size_m > 0, "root_size_m", "(0, inf)", root_size_m);
  check_option(leaf_size_m > 0 && leaf_size_m <= root_size_m, "leaf_size_m", "(0, root_size_m]", leaf_size_m);
  const double layers = std::log2(root_size_m / leaf_size_m);
  check_option(std::abs(layers - std::round(layers)) < 1e-9, "root_size_m / leaf_size_m", "powers of two",
               root_size_m / leaf_size_m);
}

VoxelMap::VoxelMap(const PointCloud& cloud, const VoxelMapOptions& options) : options_(options), origin_(cloud.origin) {
  options.validate();
  const int num_layers = layers_of(options);
  const int bits = num_layers - 1;
  const double leaf = options.leaf_size_m;

  struct Entry {
    Eigen::Vector3i root;
    uint64_t code;
    uint32_t index;
  };
  std::vector<Entry> entries;
  entries.reserve(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d x = cloud.point(i);
    if (!x.allFinite()) continue;
    const Eigen::Vector3i cell = (x / leaf).array().floor().cast<int>();
    const Eigen::Vector3i root = cell.unaryExpr([&](int v) { return floor_div_pow2(v, bits); });
    entries.push_back({root, morton(cell - root * (1 << bits), bits), static_cast<uint32_t>(i)});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    if (a.root != b.root) return key_less(a.root, b.root);
    if (a.code != b.code) return a.code < b.code;
    return a.index < b.index;
  });

  layers_.resize(static_cast<size_t>(num_layers));
  for (size_t i = 0; i < entries.size(); ++i) {
    const Entry& e = entries[i];
    positions_.push_back(cloud.positions[e.index]);
    input_indices_.push_back(e.index);
    const bool new_root = i == 0 || e.root != entries[i - 1].root;
    if (new_root) root_keys_.push_back(e.root);
    for (int l = 0; l < num_layers; ++l) {
      const uint64_t code = e.code >> (3 * (bits - l));
      const bool new_node = new_root || code != (entries[i - 1].code >> (3 * (bits - l)));
      if (!new_node) continue;
      Layer& layer = layers_[static_cast<size_t>(l)];
      layer.points_begin.push_back(static_cast<uint32_t>(i));
      layer.codes.push_back(code);
      layer.root.push_back(static_cast<uint32_t>(root_keys_.size() - 1));
      if (l < bits) layer.children_begin.push_back(static_cast<uint32_t>(layers_[static_cast<size_t>(l) + 1].codes.size()));
    }
  }
  for (int l = 0; l < num_layers; ++l) {
    Layer& layer = layers_[static_cast<size_t>(l)];
    layer.points_begin.push_back(static_cast<uint32_t>(entries.size()));
    if (l < bits) layer.children_begin.push_back(static_cast<uint32_t>(layers_[static_cast<size_t>(l) + 1].codes.size()));
  }
}

double VoxelMap::voxel_size(int layer) const { return options_.root_size_m / static_cast<double>(1 << layer); }

uint32_t VoxelMap::num_nodes(int layer) const {
  return static_cast<uint32_t>(layers_[static_cast<size_t>(layer)].codes.size());
}

uint32_t VoxelMap::points_begin(int layer, uint32_t node) const {
  return layers_[static_cast<size_t>(layer)].points_begin[node];
}

uint32_t VoxelMap::children_begin(int layer, uint32_t node) const {
  return layers_[static_cast<size_t>(layer)].children_begin[node];
}

uint32_t VoxelMap::parent(int layer, uint32_t node) const {
  const std::vector<uint32_t>& begin = layers_[static_cast<size_t>(layer) - 1].children_begin;
  return static_cast<uint32_t>(std::upper_bound(begin.begin(), begin.end(), node) - begin.begin()) - 1;
}

VoxelStatistics VoxelMap::statistics(int layer, uint32_t node) const {
  const uint32_t begin = points_begin(layer, node);
  const uint32_t end = points_end(layer, node);
  VoxelStatistics s;
  s.count = end - begin;
  for (uint32_t i = begin; i < end; ++i) s.mean += point(i);
  s.mean /= static_cast<double>(s.count);
  for (uint32_t i = begin; i < end; ++i) {
    const Eigen::Vector3d d = point(i) - s.mean;
    s.covariance += d * d.transpose();
  }
  s.covariance /= static_cast<double>(s.count);
  return s;
}

Eigen::Vector3i VoxelMap::key(int layer, uint32_t node) const {
  const Layer& l = layers_[static_cast<size_t>(layer)];
  return root_keys_[l.root[node]] * (1 << layer) + morton_cell(l.codes[node], layer);
}

Eigen::Vector3i VoxelMap::key_of(int layer, const Eigen::Vector3d& x_in_map) const {
  // From the leaf's key, so that rounding at a border is the same in every layer.
  const Eigen::Vector3i cell = (x_in_map / options_.leaf_size_m).array().floor().cast<int>();
  return cell.unaryExpr([&](int v) { return floor_div_pow2(v, leaf_layer() - layer); });
}

Eigen::Vector3d VoxelMap::center(int layer, uint32_t node) const {
  return (key(layer, node).cast<double>().array() + 0.5) * voxel_size(layer);
}

std::optional<uint32_t> VoxelMap::find(int layer, const Eigen::Vector3i& key) const {
  const Eigen::Vector3i root_key = key.unaryExpr([&](int v) { return floor_div_pow2(v, layer); });
  const auto root = std::lower_bound(root_keys_.begin(), root_keys_.end(), root_key, key_less);
  if (root == root_keys_.end() || *root != root_key) return std::nullopt;
  const uint64_t code = morton(key - root_key * (1 << layer), layer);
  uint32_t begin = static_cast<uint32_t>(root - root_keys_.begin());
  uint32_t end = begin + 1;
  for (int l = 0; l < layer; ++l) {
    begin = children_begin(l, begin);
    end = children_begin(l, end);
  }
  const std::vector<uint64_t>& codes = layers_[static_cast<size_t>(layer)].codes;
  const auto it = std::lower_bound(codes.begin() + begin, codes.begin() + end, code);
  if (it == codes.begin() + end || *it != code) return std::nullopt;
  return static_cast<uint32_t>(it - codes.begin());
}

void VoxelMap::neighbors(int layer, uint32_t node, bool faces_only, std::vector<uint32_t>* nodes) const {
  nodes->clear();
  const Eigen::Vector3i center_key = key(layer, node);
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        const int distance = std::abs(dx) + std::abs(dy) + std::abs(dz);
        if (distance == 0 || (faces_only && distance > 1)) continue;
        if (const auto found = find(layer, center_key + Eigen::Vector3i(dx, dy, dz))) nodes->push_back(*found);
      }
    }
  }
  std::sort(nodes->begin(), nodes->end());
}

std::vector<uint32_t> VoxelMap::roots_in_radius(const Eigen::Vector3d& x_in_map, double radius_m) const {
  std::vector<uint32_t> roots;
  for (uint32_t root = 0; root < num_nodes(0); ++root) {
    const Eigen::Vector3d to_box = ((x_in_map - center(0, root)).cwiseAbs().array() - 0.5 * options_.root_size_m).max(0.0);
    if (to_box.squaredNorm() <= radius_m * radius_m) roots.push_back(root);
  }
  return roots;
}

}  // namespace cpplus
