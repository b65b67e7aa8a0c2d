#include "cpplus/features/merge_layers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "cpplus/core/parallel.h"
#include "cpplus/features/leaf_planes.h"
#include "cpplus/features/refit_planes.h"
#include "cpplus/features/settle_points.h"

namespace cpplus {
namespace {

constexpr double kMinCos = 0.97;
constexpr double kMaxOffset = 0.06;  // metres between two layers
constexpr double kCell = 0.1;        // metres; layers lie over each other where both have points in a cell
constexpr double kMinOverlap = 0.7;  // of the smaller layer's points
constexpr double kBin = 0.004;       // metres across the layers
constexpr int kHalfBins = 30;
constexpr int kSmooth = 2;           // bins to each side
constexpr double kMinValley = 0.75;  // of the smaller layer's peak; deeper valleys part two surfaces

using PlanePair = std::pair<int32_t, int32_t>;  // the larger plane first

class LayerMerger {
 public:
  LayerMerger(const VoxelMap& map, const LeafNeighbors& neighbors, const PlaneSegmentation& planes)
      : map_(map), neighbors_(neighbors), planes_(planes) {}

  // The plane that each one becomes part of.
  std::vector<int32_t> run() const {
    const std::vector<PlanePair> pairs = find_pairs();
    std::vector<char> is_one(pairs.size());
    parallel_for_each(pairs.size(), [&](size_t k) { is_one[k] = is_one_surface(pairs[k]); });
    std::vector<int32_t> root(planes_.planes.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int32_t id) {
      while (root[static_cast<size_t>(id)] != id) id = root[static_cast<size_t>(id)];
      return id;
    };
    for (size_t k = 0; k < pairs.size(); ++k) {
      if (!is_one[k]) continue;
      int32_t a = find(pairs[k].first);
      int32_t b = find(pairs[k].second);
      if (a == b) continue;
      if (is_larger(b, a)) std::swap(a, b);
      // Layer by layer a surface could creep away from where it began.
      if (std::abs(plane(a).signed_distance(plane(b).centroid)) > kMaxOffset) continue;
      root[static_cast<size_t>(b)] = a;
    }
    for (size_t id = 0; id < root.size(); ++id) root[id] = find(static_cast<int32_t>(id));
    return root;
  }

 private:
  const MapPlane& plane(int32_t id) const { return planes_.planes[static_cast<size_t>(id)]; }

  bool is_larger(int32_t a, int32_t b) const {
    return plane(a).num_points != plane(b).num_points ? plane(a).num_points > plane(b).num_points : a < b;
  }

  std::vector<PlanePair> find_pairs() const {
    const LeafPlanes planes_of_leaf(map_, planes_.plane_of_point);
    constexpr size_t kGrain = 4096;
    const uint32_t num_leaves = map_.num_nodes(map_.leaf_layer());
    std::vector<std::vector<PlanePair>> chunks((num_leaves + kGrain - 1) / kGrain);
    parallel_for_chunks(num_leaves, kGrain, [&](size_t begin, size_t end) {
      std::vector<PlanePair>& found = chunks[begin / kGrain];
      const auto add = [&](uint32_t leaf, uint32_t other) {
        for (const int32_t a : planes_of_leaf[leaf]) {
          for (const int32_t b : planes_of_leaf[other]) {
            if (a == b || std::abs(plane(a).normal.dot(plane(b).normal)) < kMinCos) continue;
            const PlanePair pair = is_larger(a, b) ? PlanePair(a, b) : PlanePair(b, a);
            if (!found.empty() && found.back() == pair) continue;
            if (std::abs(plane(pair.first).signed_distance(plane(pair.second).centroid)) < kMaxOffset)
              found.push_back(pair);
          }
        }
      };
      for (size_t k = begin; k < end; ++k) {
        const uint32_t leaf = static_cast<uint32_t>(k);
        if (planes_of_leaf[leaf].empty()) continue;
        add(leaf, leaf);
        for (const uint32_t neighbor : neighbors_[leaf]) {
          if (neighbor > leaf) add(leaf, neighbor);
        }
      }
      std::sort(found.begin(), found.end());
      found.erase(std::unique(found.begin(), found.end()), found.end());
    });
    std::vector<PlanePair> pairs;
    for (const std::vector<PlanePair>& chunk : chunks) pairs.insert(pairs.end(), chunk.begin(), chunk.end());
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
  }

  struct Sample {
    int64_t cell;
    float distance;  // from the larger plane, metres
    bool of_smaller;
    bool operator<(const Sample& other) const { return cell < other.cell; }
  };

  // The points of both planes around the smaller one.
  std::vector<Sample> samples_of(const PlanePair& pair) const {
    const MapPlane& base = plane(pair.first);
    const Eigen::Vector3d axis_u = base.normal.unitOrthogonal();
    const Eigen::Vector3d axis_v = base.normal.cross(axis_u);
    std::vector<uint32_t> leaves;
    for (const uint32_t leaf : planes_.leaves[static_cast<size_t>(pair.second)]) {
      leaves.push_back(leaf);
      leaves.insert(leaves.end(), neighbors_[leaf].begin(), neighbors_[leaf].end());
    }
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    std::vector<Sample> samples;
    for (const uint32_t leaf : leaves) {
      for (uint32_t i = map_.points_begin(map_.leaf_layer(), leaf); i < map_.points_end(map_.leaf_layer(), leaf); ++i) {
        const int32_t id = planes_.plane_of_point[i];
        if (id != pair.first && id != pair.second) continue;
        const Eigen::Vector3d d = map_.point(i) - base.centroid;
        const int64_t u = static_cast<int64_t>(std::floor(axis_u.dot(d) / kCell));
        const int64_t v = static_cast<int64_t>(std::floor(axis_v.dot(d) / kCell));
        samples.push_back({u * (int64_t{1} << 32) + v, static_cast<float>(base.normal.dot(d)), id == pair.second});
      }
    }
    std::sort(samples.begin(), samples.end());
    return samples;
  }

  bool is_one_surface(const PlanePair& pair) const {
    const std::vector<Sample> samples = samples_of(pair);
    std::array<double, 2 * kHalfBins + 1> histogram{};
    std::array<double, 2> count{};  // larger, smaller, where both are
    std::array<double, 2> sum{};
    double of_smaller = 0.0;
    for (size_t begin = 0; begin < samples.size();) {
      size_t end = begin;
      size_t smaller = 0;
      for (; end < samples.size() && samples[end].cell == samples[begin].cell; ++end)
        smaller += samples[end].of_smaller;
      of_smaller += static_cast<double>(smaller);
      if (smaller > 0 && 3 * (end - begin - smaller) >= smaller) {
        for (size_t k = begin; k < end; ++k) {
          const int bin = static_cast<int>(std::lround(samples[k].distance / kBin)) + kHalfBins;
          if (bin >= 0 && bin <= 2 * kHalfBins) histogram[static_cast<size_t>(bin)] += 1.0;
          count[samples[k].of_smaller] += 1.0;
          sum[samples[k].of_smaller] += samples[k].distance;
        }
      }
      begin = end;
    }
    if (count[1] < kMinOverlap * of_smaller || count[0] < 1.0) return false;
    return has_one_mode(histogram, sum[0] / count[0], sum[1] / count[1]);
  }

  static bool has_one_mode(const std::array<double, 2 * kHalfBins + 1>& histogram, double larger, double smaller) {
    const auto density = [&](int bin) {
      double total = 0.0;
      for (int k = std::max(0, bin - kSmooth); k <= std::min(2 * kHalfBins, bin + kSmooth); ++k)
        total += histogram[static_cast<size_t>(k)];
      return total;
    };
    const auto bin_of = [](double distance) {
      return std::clamp(static_cast<int>(std::lround(distance / kBin)) + kHalfBins, 0, 2 * kHalfBins);
    };
    const int from = bin_of(larger);
    const int to = bin_of(smaller);
    const int step = to >= from ? 1 : -1;
    int valley = from;
    for (int k = from; k != to + step; k += step) {
      if (density(k) < density(valley)) valley = k;
    }
    double peak = 0.0;
    for (int k = valley; k >= 0 && k <= 2 * kHalfBins; k += step) peak = std::max(peak, density(k));
    return density(valley) >= kMinValley * peak - 2.0 * std::sqrt(peak);
  }

  const VoxelMap& map_;
  const LeafNeighbors& neighbors_;
  const PlaneSegmentation& planes_;
};

}  // namespace

void merge_layers(const VoxelMap& map, const LeafNeighbors& neighbors, PlaneSegmentation* planes) {
  const std::vector<int32_t> root = LayerMerger(map, neighbors, *planes).run();
  std::vector<int32_t> plane_of_point = planes->plane_of_point;
  for (int32_t& id : plane_of_point) {
    if (id >= 0) id = root[static_cast<size_t>(id)];
  }
  refit_planes(map, plane_of_point, 1, planes);
  // The layers have lost the points near corners to planes that were nearer than they, but not than the whole is.
  settle_points(map, neighbors, SettlePointsOptions(), planes);
}

}  // namespace cpplus
