#include "cpplus/cloud/point_octree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr double kFinestStepM = 1e-4;
constexpr int kCellLevels = 7;  // log2 of point_octree_cells
static_assert(1 << kCellLevels == point_octree_cells);
constexpr size_t kGrain = 1 << 16;
constexpr int kNumOctants = 8;

/// Which point of a range stands for each cell of a node.
class CellTable {
 public:
  CellTable() : cells_(size_t{1} << (3 * kCellLevels)) {}

  void offer(uint32_t cell, uint32_t place, float distance) {
    if (distance < cells_[cell].distance) cells_[cell] = {place, distance};
  }
  bool holds(uint32_t cell, uint32_t place) const { return cells_[cell].place == place; }
  void clear(uint32_t cell) { cells_[cell] = {}; }

 private:
  struct Cell {
    uint32_t place = std::numeric_limits<uint32_t>::max();
    float distance = std::numeric_limits<float>::infinity();
  };
  std::vector<Cell> cells_;
};

/// Hands each thread a table of its own; tables come back cleared.
class CellTables {
 public:
  std::unique_ptr<CellTable> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<CellTable>();
    std::unique_ptr<CellTable> table = std::move(free_.back());
    free_.pop_back();
    return table;
  }
  void give_back(std::unique_ptr<CellTable> table) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(table));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<CellTable>> free_;
};

void put_on_steps(const PointCloud& cloud, PointOctree* octree) {
  Eigen::Vector3f low = cloud.positions.front(), high = low;
  for (const Eigen::Vector3f& x : cloud.positions) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  // Two steps are left for rounding at either end.
  const double most_steps = std::numeric_limits<int32_t>::max() - 2.0;
  octree->step_m = kFinestStepM;
  int tens = 0;
  while ((high - low).cast<double>().maxCoeff() / octree->step_m > most_steps) {
    octree->step_m = kFinestStepM * std::pow(10.0, ++tens);
  }
  const Eigen::Vector3d lowest = cloud.origin + low.cast<double>();
  octree->corner_in_map = (lowest / octree->step_m).array().floor() * octree->step_m;
  octree->steps.resize(cloud.size());
  const Eigen::Vector3d from_corner = cloud.origin - octree->corner_in_map;
  parallel_for_chunks(cloud.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d steps = (from_corner + cloud.positions[i].cast<double>()) / octree->step_m;
      octree->steps[i] = steps.array().round().cast<int>().max(0);
    }
  });
  int most = point_octree_cells - 1;
  for (const Eigen::Vector3i& steps : octree->steps) most = std::max(most, steps.maxCoeff());
  octree->edge_steps = most + 1;
}

class OctreeBuilder {
 public:
  OctreeBuilder(const PointOctreeOptions& options, PointOctree* octree)
      : options_(options), octree_(*octree), cells_(octree->steps.size()), scratch_(octree->steps.size()) {
    octree_.order.resize(octree_.steps.size());
    std::iota(octree_.order.begin(), octree_.order.end(), 0u);
  }

  void build() {
    PointOctreeNode root;
    root.num_points = static_cast<uint32_t>(octree_.order.size());
    octree_.nodes = {root};
    for (size_t begin = 0; begin < octree_.nodes.size();) {
      const size_t end = octree_.nodes.size();
      divide_level(begin, end);
      begin = end;
    }
  }

 private:
  /// How many points a node keeps, and how many each octant gets.
  struct Shares {
    uint32_t kept = 0;
    std::array<uint32_t, kNumOctants> octants = {};
  };

  bool is_divided(const PointOctreeNode& node) const {
    return node.num_points > options_.max_points && octree_.edge_steps >> node.level >= point_octree_cells;
  }

  void divide_level(size_t begin, size_t end) {
    std::vector<size_t> divided;
    for (size_t i = begin; i < end; ++i) {
      if (is_divided(octree_.nodes[i])) divided.push_back(i);
    }
    std::vector<Shares> shares(divided.size());
    parallel_for_each(divided.size(), [&](size_t i) {
      std::unique_ptr<CellTable> table = tables_.take();
      shares[i] = divide(octree_.nodes[divided[i]], table.get());
      tables_.give_back(std::move(table));
    });
    for (size_t i = 0; i < divided.size(); ++i) add_children(divided[i], shares[i]);
  }

  void add_children(size_t parent, const Shares& shares) {
    uint32_t first = octree_.nodes[parent].first + shares.kept;
    octree_.nodes[parent].num_points = shares.kept;
    for (int octant = 0; octant < kNumOctants; ++octant) {
      const uint32_t num_points = shares.octants[static_cast<size_t>(octant)];
      if (num_points == 0) continue;
      octree_.nodes[parent].child_mask |= static_cast<uint8_t>(1 << octant);
      PointOctreeNode child;
      child.level = octree_.nodes[parent].level + 1;
      child.key = 2 * octree_.nodes[parent].key + Eigen::Vector3i(octant >> 2, (octant >> 1) & 1, octant & 1);
      child.first = first;
      child.num_points = num_points;
      octree_.nodes.push_back(child);
      first += num_points;
    }
  }

  /// Sorts the node's points: those that it keeps, then those of each octant, each in the order they had.
  Shares divide(const PointOctreeNode& node, CellTable* table) {
    const uint32_t end = node.first + node.num_points;
    for (uint32_t i = node.first; i < end; ++i) offer_to_cell(node, i, table);
    Shares shares;
    for (uint32_t i = node.first; i < end; ++i) {
      const bool is_kept = table->holds(cells_[i], i);
      ++(is_kept ? shares.kept : shares.octants[octant_of(cells_[i])]);
    }
    uint32_t kept = node.first;
    std::array<uint32_t, kNumOctants> next;
    next[0] = node.first + shares.kept;
    for (size_t octant = 1; octant < kNumOctants; ++octant) {
      next[octant] = next[octant - 1] + shares.octants[octant - 1];
    }
    for (uint32_t i = node.first; i < end; ++i) {
      const bool is_kept = table->holds(cells_[i], i);
      scratch_[is_kept ? kept++ : next[octant_of(cells_[i])]++] = octree_.order[i];
    }
    for (uint32_t i = node.first; i < end; ++i) table->clear(cells_[i]);
    std::copy(scratch_.begin() + node.first, scratch_.begin() + end, octree_.order.begin() + node.first);
    return shares;
  }

  void offer_to_cell(const PointOctreeNode& node, uint32_t place, CellTable* table) {
    const Eigen::Vector3i& steps = octree_.steps[octree_.order[place]];
    const uint64_t edge = static_cast<uint64_t>(octree_.edge_steps);
    uint32_t cell = 0;
    float distance = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      // In units of 1 / edge_steps of a cell; at most 2^62, as cells are not smaller than a step.
      const uint64_t along = static_cast<uint64_t>(steps[axis]) << (node.level + kCellLevels);
      const uint64_t cell_along = along / edge;
      const float from_middle = static_cast<float>(along - cell_along * edge) - 0.5f * static_cast<float>(edge);
      distance += from_middle * from_middle;
      cell = cell << kCellLevels | static_cast<uint32_t>(cell_along & (point_octree_cells - 1));
    }
    cells_[place] = cell;
    table->offer(cell, place, distance);
  }

  static size_t octant_of(uint32_t cell) {
    constexpr int kTopBit = kCellLevels - 1;
    return (cell >> (2 * kCellLevels + kTopBit) & 1) << 2 | (cell >> (kCellLevels + kTopBit) & 1) << 1 |
           (cell >> kTopBit & 1);
  }

  const PointOctreeOptions& options_;
  PointOctree& octree_;
  CellTables tables_;
  std::vector<uint32_t> cells_;    // of the point at each place of `order`, in the node that was divided last
  std::vector<uint32_t> scratch_;  // as `order`
};

}  // namespace

PointOctree build_point_octree(const PointCloud& cloud, const PointOctreeOptions& options) {
  assert(!cloud.empty());
  if (cloud.size() > std::numeric_limits<uint32_t>::max() - 1) {
    throw Error(fmt::format("{} points are too many for an octree; at most 2^32 - 2", cloud.size()));
  }
  PointOctree octree;
  put_on_steps(cloud, &octree);
  OctreeBuilder(options, &octree).build();
  return octree;
}

}  // namespace cpplus
