#include "cpplus/features/crease_edges.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>

#include "cpplus/core/parallel.h"
#include "cpplus/features/leaf_neighbors.h"
#include "cpplus/features/leaf_planes.h"
#include "cpplus/features/local_plane.h"
#include "cpplus/features/merge_layers.h"

namespace cpplus {
namespace {

constexpr double kBin = 0.05;  // metres along the edge

using PlanePair = std::pair<int32_t, int32_t>;

// A line with the in-plane directions of its two planes.
struct Line {
  Eigen::Vector3d point;
  Eigen::Vector3d direction;
};

std::optional<Line> intersect(const Eigen::Vector3d& normal_a, const Eigen::Vector3d& centroid_a,
                              const Eigen::Vector3d& normal_b, const Eigen::Vector3d& centroid_b,
                              const Eigen::Vector3d& near) {
  const Eigen::Vector3d cross = normal_a.cross(normal_b);
  if (cross.norm() < 1e-3) return std::nullopt;
  const Eigen::Vector3d direction = cross.normalized();
  Eigen::Matrix3d system;
  system << normal_a.transpose(), normal_b.transpose(), direction.transpose();
  const Eigen::Vector3d right(normal_a.dot(centroid_a - near), normal_b.dot(centroid_b - near), 0.0);
  return Line{near + system.inverse() * right, direction};
}

class CreaseFinder {
 public:
  CreaseFinder(const VoxelMap& map, const LeafNeighbors& neighbors, const PlaneSegmentation& planes,
               const CreaseEdgeOptions& options)
      : map_(map),
        neighbors_(neighbors),
        planes_(planes),
        options_(options),
        max_cos_(std::cos(options.min_angle_deg * std::numbers::pi / 180.0)),
        // The strip must be wider than the noise of the other plane, which its points cannot be told from.
        support_distance_(std::max(options.support_distance_m, 6.0 * planes.noise_m)) {}

  std::vector<MapEdge> run() {
    const std::vector<Contact> contacts = find_contacts();
    std::vector<size_t> first;  // contact of each pair, and the end
    for (size_t i = 0; i < contacts.size(); ++i) {
      if (i == 0 || contacts[i].pair != contacts[i - 1].pair) first.push_back(i);
    }
    first.push_back(contacts.size());
    std::vector<std::vector<MapEdge>> edges_of_pair(first.size() - 1);
    parallel_for_each(edges_of_pair.size(), [&](size_t k) {
      std::vector<uint32_t> leaves;
      for (size_t i = first[k]; i < first[k + 1]; ++i) leaves.push_back(contacts[i].leaf);
      edges_of_pair[k] = edges_of(contacts[first[k]].pair, leaves);
    });
    return concatenate_groups(edges_of_pair);
  }

 private:
  // A leaf in or beside which two planes touch at an angle in range.
  struct Contact {
    PlanePair pair;
    uint32_t leaf;
    bool operator<(const Contact& other) const { return std::tie(pair, leaf) < std::tie(other.pair, other.leaf); }
    bool operator==(const Contact& other) const { return pair == other.pair && leaf == other.leaf; }
  };

  std::vector<Contact> find_contacts() const {
    const LeafPlanes planes_of_leaf(map_, planes_.plane_of_point);
    constexpr size_t kGrain = 4096;
    const size_t num_leaves = map_.num_nodes(map_.leaf_layer());
    std::vector<std::vector<Contact>> chunks((num_leaves + kGrain - 1) / kGrain);
    parallel_for_chunks(num_leaves, kGrain, [&](size_t begin, size_t end) {
      std::vector<Contact>& found = chunks[begin / kGrain];
      for (size_t k = begin; k < end; ++k) {
        const uint32_t leaf = static_cast<uint32_t>(k);
        if (planes_of_leaf[leaf].empty()) continue;
        const size_t before = found.size();
        add_contacts(leaf, planes_of_leaf[leaf], planes_of_leaf[leaf], &found);
        for (const uint32_t neighbor : neighbors_[leaf])
          add_contacts(leaf, planes_of_leaf[leaf], planes_of_leaf[neighbor], &found);
        std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end());
        found.erase(std::unique(found.begin() + static_cast<std::ptrdiff_t>(before), found.end()), found.end());
      }
    });
    std::vector<Contact> contacts;
    for (const std::vector<Contact>& chunk : chunks) contacts.insert(contacts.end(), chunk.begin(), chunk.end());
    std::sort(contacts.begin(), contacts.end());
    return contacts;
  }

  void add_contacts(uint32_t leaf, std::span<const int32_t> planes_a, std::span<const int32_t> planes_b,
                    std::vector<Contact>* found) const {
    for (const int32_t a : planes_a) {
      for (const int32_t b : planes_b) {
        if (a != b && angle_in_range(a, b)) found->push_back({std::minmax(a, b), leaf});
      }
    }
  }

  const MapPlane& plane(int32_t id) const { return planes_.planes[static_cast<size_t>(id)]; }

  bool angle_in_range(int32_t a, int32_t b) const { return std::abs(plane(a).normal.dot(plane(b).normal)) < max_cos_; }

  // What one plane shows along a line, per bin. Points within the noise of the other plane may be the other's: they
  // show that the surface reaches the line, but neither where it ends nor on which side it lies.
  struct Support {
    explicit Support(size_t bins)
        : nearest(bins, std::numeric_limits<float>::infinity()),
          points(bins),
          left(bins),
          right(bins),
          first(bins, std::numeric_limits<double>::max()),
          last(bins, std::numeric_limits<double>::lowest()) {}
    std::vector<float> nearest;  // metres from the line, infinity = none
    std::vector<int> points;
    std::vector<int> left;  // off the other plane
    std::vector<int> right;
    std::vector<double> first;  // metres along the line, off the other plane
    std::vector<double> last;
  };

  struct Range {
    double begin;
    int num_bins;
  };

  std::vector<MapEdge> edges_of(const PlanePair& pair, const std::vector<uint32_t>& leaves) const {
    Eigen::Vector3d near = Eigen::Vector3d::Zero();
    for (const uint32_t leaf : leaves) near += map_.center(map_.leaf_layer(), leaf);
    near /= static_cast<double>(leaves.size());
    const MapPlane& a = plane(pair.first);
    const MapPlane& b = plane(pair.second);
    const std::optional<Line> line = intersect(a.normal, a.centroid, b.normal, b.centroid, near);
    if (!line) return {};

    double begin = std::numeric_limits<double>::max();
    double end = -begin;
    std::vector<uint32_t> around;
    for (const uint32_t leaf : leaves) {
      const double t = line->direction.dot(map_.center(map_.leaf_layer(), leaf) - line->point);
      begin = std::min(begin, t);
      end = std::max(end, t);
      around.push_back(leaf);
      around.insert(around.end(), neighbors_[leaf].begin(), neighbors_[leaf].end());
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    begin -= map_.options().leaf_size_m;
    end += map_.options().leaf_size_m;
    const Range range{begin, static_cast<int>(std::ceil((end - begin) / kBin))};

    const Support support_a = support_of(pair.first, pair.second, *line, around, range);
    const Support support_b = support_of(pair.second, pair.first, *line, around, range);
    return edges_along(pair, *line, range, support_a, support_b);
  }

  Support support_of(int32_t id, int32_t other, const Line& line, const std::vector<uint32_t>& leaves,
                     const Range& range) const {
    const Eigen::Vector3d side = line.direction.cross(plane(id).normal);
    const double keep_off = 3.0 * planes_.noise_m;
    Support support(static_cast<size_t>(range.num_bins));
    for (const uint32_t leaf : leaves) {
      for (uint32_t i = map_.points_begin(map_.leaf_layer(), leaf); i < map_.points_end(map_.leaf_layer(), leaf); ++i) {
        if (planes_.plane_of_point[i] != id) continue;
        const Eigen::Vector3d x = map_.point(i);
        const double s = side.dot(x - line.point);
        const double t = line.direction.dot(x - line.point);
        const int bin = static_cast<int>(std::floor((t - range.begin) / kBin));
        if (bin < 0 || bin >= range.num_bins || std::abs(s) > support_distance_) continue;
        const size_t k = static_cast<size_t>(bin);
        support.nearest[k] = std::min(support.nearest[k], static_cast<float>(std::abs(s)));
        ++support.points[k];
        if (std::abs(plane(other).signed_distance(x)) < keep_off) continue;
        ++(s < 0 ? support.left : support.right)[k];
        support.first[k] = std::min(support.first[k], t);
        support.last[k] = std::max(support.last[k], t);
      }
    }
    return support;
  }

  // The plane has points of its own in the bin, and around it reaches the line; otherwise the two only hang close to
  // each other.
  std::vector<bool> supported_bins(const Support& support) const {
    const int bins = static_cast<int>(support.nearest.size());
    std::vector<int> own;
    for (size_t k = 0; k < support.left.size(); ++k) {
      if (support.left[k] + support.right[k] > 0) own.push_back(support.left[k] + support.right[k]);
    }
    if (own.empty()) return std::vector<bool>(static_cast<size_t>(bins), false);
    std::nth_element(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2), own.end());
    const double enough = kMinShare * own[own.size() / 2];
    std::vector<bool> supported;
    std::vector<float> nearest;
    for (int k = 0; k < bins; ++k) {
      nearest.clear();
      int points = 0;
      for (int m = std::max(0, k - kWindow); m <= std::min(bins - 1, k + kWindow); ++m) {
        const size_t bin = static_cast<size_t>(m);
        if (support.points[bin] > 0) nearest.push_back(support.nearest[bin]);
        points += support.points[bin];
      }
      const int here = support.left[static_cast<size_t>(k)] + support.right[static_cast<size_t>(k)];
      if (here == 0 || here < enough) {
        supported.push_back(false);
        continue;
      }
      const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
      std::nth_element(nearest.begin(), middle, nearest.end());
      // Mean distance between neighbouring points of the strip along its width, were they spread evenly over it.
      const double spacing = support_distance_ * static_cast<double>(nearest.size()) / points;
      supported.push_back(*middle < options_.max_gap_m + std::min(spacing, options_.max_gap_m));
    }
    return supported;
  }

  // Runs of bins in which both planes have points; up to three missing bins between supported ones are bridged.
  std::vector<MapEdge> edges_along(const PlanePair& pair, const Line& line, const Range& range, const Support& a,
                                   const Support& b) const {
    const std::vector<bool> supported_a = supported_bins(a);
    const std::vector<bool> supported_b = supported_bins(b);
    const auto supported = [&](int k) {
      return supported_a[static_cast<size_t>(k)] && supported_b[static_cast<size_t>(k)];
    };
    std::vector<MapEdge> edges;
    uint32_t group = 0;
    int begin = 0;
    while (begin < range.num_bins) {
      if (!supported(begin)) {
        ++begin;
        continue;
      }
      int end = begin + 1;  // one past the last supported bin
      for (int k = end; k < range.num_bins && k <= end + kMaxGapBins; ++k) {
        if (supported(k)) end = k + 1;
      }
      const size_t first = static_cast<size_t>(begin);
      const size_t last = static_cast<size_t>(end - 1);
      const double from = std::max(a.first[first], b.first[first]);
      const double to = std::min(a.last[last], b.last[last]);
      const int side_a = side_of(a, begin, end);
      const int side_b = side_of(b, begin, end);
      // Where both go on behind the line it is no corner but clutter that two planes pass through.
      if (to - from >= options_.min_length_m && (side_a != 0 || side_b != 0))
        append_pieces(pair, line, from, to, side_a, side_b, group++, &edges);
      begin = end + 1;
    }
    return edges;
  }

  // +1 or -1: the side of the line on which the plane lies; 0: it goes on behind the edge.
  static int side_of(const Support& support, int begin, int end) {
    int left = 0;
    int right = 0;
    for (int k = begin; k < end; ++k) {
      left += support.left[static_cast<size_t>(k)];
      right += support.right[static_cast<size_t>(k)];
    }
    if (right > 3 * left) return 1;
    if (left > 3 * right) return -1;
    return 0;
  }

  void append_pieces(const PlanePair& pair, const Line& line, double begin, double end, int side_a, int side_b,
                     uint32_t group, std::vector<MapEdge>* edges) const {
    const int pieces = static_cast<int>(std::ceil((end - begin) / options_.max_length_m));
    const double length = (end - begin) / pieces;
    for (int piece = 0; piece < pieces; ++piece) {
      const double t = begin + (piece + 0.5) * length;
      const Eigen::Vector3d middle = line.point + t * line.direction;
      const LinePiece around{middle, line.direction, length};
      const auto a = fit_local_plane(map_, planes_, pair.first, pair.second, around, options_.fit_distance_m);
      if (!a) continue;
      const auto b = fit_local_plane(map_, planes_, pair.second, pair.first, around, options_.fit_distance_m);
      if (!b || std::abs(a->normal.dot(b->normal)) > max_cos_) continue;
      const std::optional<Line> refined = intersect(a->normal, a->centroid, b->normal, b->centroid, middle);
      if (!refined || std::abs(refined->direction.dot(line.direction)) < 0.99) continue;
      if ((refined->point - middle).norm() > options_.max_gap_m + 2.0 * planes_.noise_m) continue;
      const Eigen::Vector3d direction =
          refined->direction.dot(line.direction) > 0 ? refined->direction : Eigen::Vector3d(-refined->direction);
      MapEdge edge;
      edge.start = refined->point - 0.5 * length * direction;
      edge.end = refined->point + 0.5 * length * direction;
      edge.normal_a = a->normal;
      edge.normal_b = b->normal;
      edge.inward_a = side_a * direction.cross(plane(pair.first).normal).normalized();
      edge.inward_b = side_b * direction.cross(plane(pair.second).normal).normalized();
      edge.covariance = covariance_of(*a, *b, direction, side_a != 0 && side_b != 0);
      edge.group = group;
      edges->push_back(edge);
    }
  }

  // Position errors e of the two planes along their normals move the line by d with normal_a d = e_a, normal_b d = e_b.
  Eigen::Matrix3d covariance_of(const LocalPlane& a, const LocalPlane& b, const Eigen::Vector3d& direction,
                                bool both_end) const {
    Eigen::Matrix3d system;
    system << a.normal.transpose(), b.normal.transpose(), direction.transpose();
    const Eigen::Matrix3d from_errors = system.inverse();
    const double map_variance = options_.map_sigma_m * options_.map_sigma_m;
    const Eigen::Vector3d variances(a.offset_variance + map_variance, b.offset_variance + map_variance, 0.0);
    Eigen::Matrix3d covariance = from_errors * variances.asDiagonal() * from_errors.transpose();
    if (!both_end) {
      covariance += kBehindSigma * kBehindSigma * (Eigen::Matrix3d::Identity() - direction * direction.transpose());
    }
    return covariance;
  }

  // Where a plane goes on behind the edge, the thing before it often ends short of it (docs/map_edges.md), metres.
  static constexpr double kBehindSigma = 0.012;
  static constexpr int kMaxGapBins = 3;
  static constexpr int kWindow = 2;         // bins to each side that tell whether a plane reaches the line
  static constexpr double kMinShare = 0.1;  // of the middle number of points a bin, where a plane is taken to end

  const VoxelMap& map_;
  const LeafNeighbors& neighbors_;
  const PlaneSegmentation& planes_;
  const CreaseEdgeOptions& options_;
  double max_cos_;
  double support_distance_;
};

}  // namespace

void CreaseEdgeOptions::validate() const {
  check_option(min_angle_deg > 0 && min_angle_deg <= 90, "min_angle_deg", "(0, 90]", min_angle_deg);
  check_option(min_length_m > 0, "min_length_m", "(0, inf)", min_length_m);
  check_option(max_length_m > 0, "max_length_m", "(0, inf)", max_length_m);
  check_option(support_distance_m > 0, "support_distance_m", "(0, inf)", support_distance_m);
  check_option(max_gap_m >= 0, "max_gap_m", "[0, inf)", max_gap_m);
  check_option(fit_distance_m > 0, "fit_distance_m", "(0, inf)", fit_distance_m);
  check_option(map_sigma_m >= 0, "map_sigma_m", "[0, inf)", map_sigma_m);
}

std::vector<MapEdge> find_crease_edges(const VoxelMap& map, const PlaneSegmentation& planes,
                                       const CreaseEdgeOptions& options) {
  options.validate();
  if (map.num_points() == 0) return {};
  const LeafNeighbors neighbors(map);
  PlaneSegmentation surfaces = planes;
  merge_layers(map, neighbors, &surfaces);
  return CreaseFinder(map, neighbors, surfaces, options).run();
}

}  // namespace cpplus
