#include "cpplus/cloud/voxel_map_build.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "cpplus/cloud/owned_map_arrays.h"
#include "cpplus/cloud/voxel_map_grid.h"
#include "cpplus/cloud/voxel_map_sort.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

// Roots are built in groups of consecutive ones with about this many points: enough to be a task.
constexpr uint32_t points_per_group = 1 << 16;

/// Sums over the points of a node, relative to the root's centre. They add up over children.
struct Sums {
  std::array<double, 3> first{};
  std::array<double, 6> second{};  // xx xy xz yy yz zz
  uint32_t count = 0;

  void add(double x, double y, double z) {
    first[0] += x;
    first[1] += y;
    first[2] += z;
    second[0] += x * x;
    second[1] += x * y;
    second[2] += x * z;
    second[3] += y * y;
    second[4] += y * z;
    second[5] += z * z;
    ++count;
  }
  void add(const Sums& other) {
    for (size_t i = 0; i < 3; ++i) first[i] += other.first[i];
    for (size_t i = 0; i < 6; ++i) second[i] += other.second[i];
    count += other.count;
  }
  /// The shift to the mean happens in double and within one root, where nothing is lost that float32 could hold.
  VoxelMoments moments() const {
    const double n = count;
    const std::array<double, 3> mean = {first[0] / n, first[1] / n, first[2] / n};
    VoxelMoments m;
    m.mean = Eigen::Vector3d(mean[0], mean[1], mean[2]).cast<float>();
    size_t k = 0;
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = i; j < 3; ++j, ++k) m.covariance[k] = static_cast<float>(second[k] / n - mean[i] * mean[j]);
    }
    return m;
  }
};

/// Nodes of one layer as they grow; see VoxelMapLayer.
struct LayerNodes {
  std::vector<uint32_t> first;
  std::vector<uint8_t> child_mask;
  std::vector<uint8_t> has_moments;
  std::vector<VoxelMoments> moments;
};

/// Sorts the points of some consecutive roots by leaf, in place, and builds their nodes.
class GroupBuilder {
 public:
  GroupBuilder(const VoxelGrid& grid, const VoxelMapOptions& options, PointsByRoot* points)
      : layers(static_cast<size_t>(grid.bits) + 1), grid_(grid), options_(options), points_(*points), block_(grid) {}

  void add_root(uint32_t root) {
    const uint32_t begin = points_.points_begin[root];
    const uint32_t size = points_.points_begin[root + 1] - begin;
    compute_codes(root, begin, size);
    sort_codes();
    apply_order(begin);
    std::vector<uint32_t> old_sizes;
    for (const LayerNodes& layer : layers) old_sizes.push_back(static_cast<uint32_t>(layer.first.size()));
    add_nodes(begin);
    add_moments(root, begin + size, old_sizes);
  }

  std::vector<LayerNodes> layers;  // children are counted from the first node of the group, points from that of the map

 private:
  // Code of the leaf in the upper half, place of the point in the root in the lower: all different, so that any sort
  // is stable.
  void compute_codes(uint32_t root, uint32_t begin, uint32_t size) {
    const Eigen::Vector3i base = points_.root_keys[root] * (1 << grid_.bits);
    codes_.resize(size);
    for (uint32_t first = 0; first < size; first += CellBlock::max_points) {
      const uint32_t block_size = std::min<uint32_t>(CellBlock::max_points, size - first);
      block_.compute({&points_.positions[begin + first], block_size});
      for (uint32_t i = 0; i < block_size; ++i) {
        const Eigen::Vector3i cell = block_.cell(i) - base;
        const uint32_t code = morton_code(static_cast<uint32_t>(cell.x()), static_cast<uint32_t>(cell.y()),
                                          static_cast<uint32_t>(cell.z()));
        codes_[first + i] = static_cast<uint64_t>(code) << 32 | (first + i);
      }
    }
  }

  void sort_codes() {
    constexpr size_t small = 256;
    if (codes_.size() <= small) {
      std::sort(codes_.begin(), codes_.end());
      return;
    }
    other_codes_.resize(codes_.size());
    constexpr int digit_bits = 8;
    constexpr uint64_t digit_mask = (1 << digit_bits) - 1;
    for (int shift = 32; shift < 32 + 3 * grid_.bits; shift += digit_bits) {
      std::array<uint32_t, digit_mask + 2> begin{};
      for (uint64_t code : codes_) ++begin[(code >> shift & digit_mask) + 1];
      std::partial_sum(begin.begin(), begin.end(), begin.begin());
      for (uint64_t code : codes_) other_codes_[begin[code >> shift & digit_mask]++] = code;
      codes_.swap(other_codes_);
    }
  }

  void apply_order(uint32_t begin) {
    const size_t size = codes_.size();
    Eigen::Vector3f* positions = points_.positions.get() + begin;
    uint32_t* indices = points_.input_indices.get() + begin;
    old_positions_.assign(positions, positions + size);
    old_indices_.assign(indices, indices + size);
    for (size_t i = 0; i < size; ++i) {
      const uint32_t from = static_cast<uint32_t>(codes_[i]);
      positions[i] = old_positions_[from];
      indices[i] = old_indices_[from];
    }
  }

  /// The leaves from the sorted codes, then each layer from the one below it. Without branches: whether a point opens a
  /// leaf, or a node its parent, is what a processor cannot predict.
  void add_nodes(uint32_t begin) {
    const uint32_t size = static_cast<uint32_t>(codes_.size());
    std::vector<uint32_t>& leaves = layers.back().first;
    const size_t old_size = leaves.size();
    leaves.resize(old_size + size);
    node_codes_.resize(size);
    uint32_t* first = leaves.data() + old_size;
    uint32_t* codes = node_codes_.data();
    // Each entry is written and then kept or overwritten by the next.
    size_t count = 0;
    for (uint32_t i = 0; i < size; ++i) {
      const uint32_t code = static_cast<uint32_t>(codes_[i] >> 32);
      const uint32_t before = i > 0 ? static_cast<uint32_t>(codes_[i - 1] >> 32) : ~code;
      first[count] = begin + i;
      codes[count] = code;
      count += code != before;
    }
    leaves.resize(old_size + count);
    node_codes_.resize(count);
    for (size_t l = layers.size() - 1; l > 0; --l) {
      add_parents(static_cast<uint32_t>(layers[l].first.size() - node_codes_.size()), &layers[l - 1]);
    }
  }

  /// Parents of the nodes whose codes are node_codes_, which become those of the parents.
  void add_parents(uint32_t first_child, LayerNodes* layer) {
    const uint32_t size = static_cast<uint32_t>(node_codes_.size());
    const size_t old_size = layer->first.size();
    layer->first.resize(old_size + size);
    layer->child_mask.resize(old_size + size);
    uint32_t* first = layer->first.data() + old_size;
    uint8_t* masks = layer->child_mask.data() + old_size;
    uint32_t* codes = node_codes_.data();
    size_t count = 0;
    uint32_t before = ~(codes[0] >> 3);
    uint32_t mask = 0;
    for (uint32_t i = 0; i < size; ++i) {
      const uint32_t code = codes[i] >> 3;
      const uint32_t octant_bit = 1u << (codes[i] & 7u);
      const bool opens = code != before;
      first[count] = first_child + i;
      codes[count] = code;
      count += opens;
      mask = (opens ? 0u : mask) | octant_bit;
      masks[count - 1] = static_cast<uint8_t>(mask);
      before = code;
    }
    layer->first.resize(old_size + count);
    layer->child_mask.resize(old_size + count);
    node_codes_.resize(count);
  }

  /// Moments of the root's inner nodes: the lowest sum their points, the others the sums of their children.
  void add_moments(uint32_t root, uint32_t points_end, const std::vector<uint32_t>& old_sizes) {
    const int leaf = grid_.bits;
    if (leaf == 0) return;
    child_sums_.clear();
    const std::vector<uint32_t>& leaves = layers[leaf].first;
    const Eigen::Vector3d root_center =
        (points_.root_keys[root].cast<double>().array() + 0.5) * options_.root_size_m - grid_.origin.array();
    const std::vector<uint32_t>& lowest = layers[leaf - 1].first;
    for (size_t node = old_sizes[leaf - 1]; node < lowest.size(); ++node) {
      const uint32_t begin = leaves[lowest[node]];
      const uint32_t end = node + 1 < lowest.size() ? leaves[lowest[node + 1]] : points_end;
      child_sums_.push_back(sum_points(begin, end, root_center));
    }
    for (int l = leaf - 1; l >= 0; --l) {
      if (l < leaf - 1) sum_children(l, old_sizes);
      for (const Sums& sums : child_sums_) {
        const bool stored = sums.count > max_points_without_moments;
        layers[l].has_moments.push_back(stored);
        if (stored) layers[l].moments.push_back(sums.moments());
      }
    }
  }

  Sums sum_points(uint32_t begin, uint32_t end, const Eigen::Vector3d& center) const {
    Sums sums;
    for (uint32_t i = begin; i < end; ++i) {
      const Eigen::Vector3f& p = points_.positions[i];
      sums.add(p.x() - center.x(), p.y() - center.y(), p.z() - center.z());
    }
    return sums;
  }

  void sum_children(int layer, const std::vector<uint32_t>& old_sizes) {
    const std::vector<uint32_t>& first = layers[layer].first;
    sums_.clear();
    size_t child = 0;
    for (size_t node = old_sizes[layer]; node < first.size(); ++node) {
      const size_t end = node + 1 < first.size() ? first[node + 1] - old_sizes[layer + 1] : child_sums_.size();
      Sums sums;
      for (; child < end; ++child) sums.add(child_sums_[child]);
      sums_.push_back(sums);
    }
    child_sums_.swap(sums_);
  }

  const VoxelGrid& grid_;
  const VoxelMapOptions& options_;
  PointsByRoot& points_;
  CellBlock block_;
  std::vector<uint64_t> codes_, other_codes_;
  std::vector<uint32_t> node_codes_;
  std::vector<Eigen::Vector3f> old_positions_;
  std::vector<uint32_t> old_indices_;
  std::vector<Sums> sums_, child_sums_;
};

/// First root of each group, and the number of roots at the end.
std::vector<uint32_t> group_roots(const std::vector<uint32_t>& points_begin) {
  std::vector<uint32_t> groups = {0};
  const uint32_t num_roots = static_cast<uint32_t>(points_begin.size()) - 1;
  for (uint32_t root = 1; root < num_roots; ++root) {
    if (points_begin[root] - points_begin[groups.back()] >= points_per_group) groups.push_back(root);
  }
  if (num_roots > 0) groups.push_back(num_roots);
  return groups;
}

struct Owner {
  PointsByRoot points;
  std::vector<uint32_t> root_table;
  std::vector<OwnedLayer> layers;
};

/// One bit a node, and the number of set bits before each word.
void pack_moments_mask(const std::vector<uint8_t>& has_moments, OwnedLayer* layer) {
  layer->moments_mask.assign((has_moments.size() + 63) / 64, 0);
  layer->moments_rank.reserve(layer->moments_mask.size());
  uint32_t rank = 0;
  for (size_t node = 0; node < has_moments.size(); ++node) {
    if (node % 64 == 0) layer->moments_rank.push_back(rank);
    layer->moments_mask[node / 64] |= static_cast<uint64_t>(has_moments[node]) << (node % 64);
    rank += has_moments[node];
  }
}

std::ptrdiff_t to_offset(size_t index) { return static_cast<std::ptrdiff_t>(index); }

/// Where the nodes of a group go in a joined layer.
struct GroupPlace {
  size_t first_node = 0;
  size_t first_moments = 0;
  uint32_t children_before = 0;
};

/// Joins one layer of all groups; frees the groups' copies.
OwnedLayer join_layer(size_t l, uint32_t num_points, std::vector<std::vector<LayerNodes>>* groups) {
  const bool is_leaf = groups->empty() || l + 1 == groups->front().size();
  std::vector<GroupPlace> places;
  GroupPlace end;
  for (const std::vector<LayerNodes>& group : *groups) {
    places.push_back(end);
    end.first_node += group[l].first.size();
    end.first_moments += group[l].moments.size();
    if (!is_leaf) end.children_before += static_cast<uint32_t>(group[l + 1].first.size());
  }
  OwnedLayer joined;
  std::vector<uint8_t> has_moments(is_leaf ? 0 : end.first_node);
  joined.first.resize(end.first_node + 1);
  joined.child_mask.resize(is_leaf ? 0 : end.first_node);
  joined.moments.resize(end.first_moments);
  parallel_for_each(groups->size(), [&](size_t g) {
    const LayerNodes nodes = std::move((*groups)[g][l]);
    const GroupPlace& place = places[g];
    std::transform(nodes.first.begin(), nodes.first.end(), joined.first.begin() + to_offset(place.first_node),
                   [&](uint32_t first) { return first + place.children_before; });
    std::copy(nodes.child_mask.begin(), nodes.child_mask.end(),
              joined.child_mask.begin() + to_offset(place.first_node));
    std::copy(nodes.has_moments.begin(), nodes.has_moments.end(), has_moments.begin() + to_offset(place.first_node));
    std::copy(nodes.moments.begin(), nodes.moments.end(), joined.moments.begin() + to_offset(place.first_moments));
  });
  joined.first.back() = is_leaf ? num_points : end.children_before;
  pack_moments_mask(has_moments, &joined);
  return joined;
}

VoxelMapArrays view(std::shared_ptr<const Owner> owner) {
  VoxelMapArrays arrays;
  arrays.positions = {owner->points.positions.get(), owner->points.num_points};
  arrays.input_indices = {owner->points.input_indices.get(), owner->points.num_points};
  arrays.root_keys = owner->points.root_keys;
  arrays.root_table = owner->root_table;
  for (const OwnedLayer& layer : owner->layers) arrays.layers.push_back(layer.view());
  arrays.owner = std::move(owner);
  return arrays;
}

}  // namespace

VoxelMapArrays build_voxel_map(const PointCloud& cloud, const VoxelMapOptions& options) {
  const VoxelGrid grid(cloud.origin, options.root_size_m, options.leaf_size_m);
  auto owner = std::make_shared<Owner>();
  owner->points = sort_points_by_root(cloud, options);
  PointsByRoot& points = owner->points;
  owner->root_table = make_root_table(points.root_keys);

  const std::vector<uint32_t> groups = group_roots(points.points_begin);
  std::vector<std::vector<LayerNodes>> nodes(groups.size() - 1);
  parallel_for_each(nodes.size(), [&](size_t g) {
    GroupBuilder builder(grid, options, &points);
    for (uint32_t root = groups[g]; root < groups[g + 1]; ++root) builder.add_root(root);
    nodes[g] = std::move(builder.layers);
  });
  free_memory(&points.points_begin);
  for (size_t l = 0; l <= static_cast<size_t>(grid.bits); ++l) {
    owner->layers.push_back(join_layer(l, static_cast<uint32_t>(points.num_points), &nodes));
  }
  VoxelMapArrays arrays = view(std::move(owner));
  arrays.num_dropped = cloud.size() - arrays.positions.size();
  return arrays;
}

}  // namespace cpplus
