#include "cpplus/features/crease_edges.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "cpplus/core/parallel.h"
#include "cpplus/features/moments.h"

namespace cpplus {
namespace {

constexpr double kBin = 0.05;  // metres along the edge

using PlanePair = std::pair<int32_t, int32_t>;

// A line with the in-plane directions of its two planes.
struct Line {
  Eigen::Vector3d point;
  Eigen::Vector3d direction;
};

struct Fit {
  Eigen::Vector3d normal;
  Eigen::Vector3d centroid;
  double offset_variance_at_line = 0.0;  // square metres
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
  CreaseFinder(const VoxelMap& map, const PlaneSegmentation& planes, const CreaseEdgeOptions& options)
      : map_(map),
        planes_(planes),
        options_(options),
        max_cos_(std::cos(options.min_angle_deg * std::numbers::pi / 180.0)) {}

  std::vector<MapEdge> run() {
    const std::map<PlanePair, std::vector<uint32_t>> pairs = adjacent_pairs();
    std::vector<std::pair<PlanePair, const std::vector<uint32_t>*>> list;
    for (const auto& [pair, leaves] : pairs) list.emplace_back(pair, &leaves);
    std::vector<std::vector<MapEdge>> edges_of_pair(list.size());
    parallel_for_each(list.size(), [&](size_t i) { edges_of_pair[i] = edges_of(list[i].first, *list[i].second); });

    return concatenate_groups(edges_of_pair);
  }

 private:
  // Pairs of planes whose leaves touch at an angle in range, with the leaves of both where they do.
  std::map<PlanePair, std::vector<uint32_t>> adjacent_pairs() const {
    std::vector<std::vector<int32_t>> planes_of_leaf(map_.num_nodes(map_.leaf_layer()));
    for (size_t p = 0; p < planes_.leaves.size(); ++p) {
      for (const uint32_t leaf : planes_.leaves[p]) planes_of_leaf[leaf].push_back(static_cast<int32_t>(p));
    }
    std::map<PlanePair, std::vector<uint32_t>> pairs;
    std::vector<uint32_t> neighbors;
    for (uint32_t leaf = 0; leaf < planes_of_leaf.size(); ++leaf) {
      if (planes_of_leaf[leaf].empty()) continue;
      map_.neighbors(map_.leaf_layer(), leaf, false, &neighbors);
      neighbors.push_back(leaf);
      for (const uint32_t neighbor : neighbors) {
        for (const int32_t a : planes_of_leaf[leaf]) {
          for (const int32_t b : planes_of_leaf[neighbor]) {
            if (a == b || !angle_in_range(a, b)) continue;
            std::vector<uint32_t>& leaves = pairs[std::minmax(a, b)];
            if (leaves.empty() || leaves.back() != leaf) leaves.push_back(leaf);
          }
        }
      }
    }
    return pairs;
  }

  const MapPlane& plane(int32_t id) const { return planes_.planes[static_cast<size_t>(id)]; }

  bool angle_in_range(int32_t a, int32_t b) const { return std::abs(plane(a).normal.dot(plane(b).normal)) < max_cos_; }

  // What one plane shows along a line: per bin, how near its points come and on which side they lie.
  struct Support {
    std::vector<float> nearest;  // metres, infinity = none
    std::vector<int> left;
    std::vector<int> right;
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
    std::vector<uint32_t> neighbors;
    for (const uint32_t leaf : leaves) {
      const double t = line->direction.dot(map_.center(map_.leaf_layer(), leaf) - line->point);
      begin = std::min(begin, t);
      end = std::max(end, t);
      around.push_back(leaf);
      map_.neighbors(map_.leaf_layer(), leaf, false, &neighbors);
      around.insert(around.end(), neighbors.begin(), neighbors.end());
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    begin -= map_.options().leaf_size_m;
    end += map_.options().leaf_size_m;
    const Range range{begin, static_cast<int>(std::ceil((end - begin) / kBin))};

    const Support support_a = support_of(pair.first, a, *line, around, range);
    const Support support_b = support_of(pair.second, b, *line, around, range);
    return edges_along(pair, *line, range, support_a, support_b);
  }

  Support support_of(int32_t id, const MapPlane& p, const Line& line, const std::vector<uint32_t>& leaves,
                     const Range& range) const {
    const Eigen::Vector3d side = line.direction.cross(p.normal);
    const size_t bins = static_cast<size_t>(range.num_bins);
    Support support{std::vector<float>(bins, std::numeric_limits<float>::infinity()), std::vector<int>(bins),
                    std::vector<int>(bins)};
    for (const uint32_t leaf : leaves) {
      for (uint32_t i = map_.points_begin(map_.leaf_layer(), leaf); i < map_.points_end(map_.leaf_layer(), leaf); ++i) {
        if (planes_.plane_of_point[i] != id) continue;
        const Eigen::Vector3d d = map_.point(i) - line.point;
        const double s = side.dot(d);
        const int bin = static_cast<int>(std::floor((line.direction.dot(d) - range.begin) / kBin));
        if (bin < 0 || bin >= range.num_bins || std::abs(s) > options_.support_distance_m) continue;
        const size_t k = static_cast<size_t>(bin);
        support.nearest[k] = std::min(support.nearest[k], static_cast<float>(std::abs(s)));
        ++(s < 0 ? support.left : support.right)[k];
      }
    }
    return support;
  }

  // Runs of bins in which both planes have points; one missing bin between two supported ones is bridged.
  std::vector<MapEdge> edges_along(const PlanePair& pair, const Line& line, const Range& range, const Support& a,
                                   const Support& b) const {
    const int min_bins = static_cast<int>(std::ceil(options_.min_length_m / kBin));
    std::vector<MapEdge> edges;
    uint32_t group = 0;
    auto supported = [&](int k) {
      const size_t i = static_cast<size_t>(k);
      return std::isfinite(a.nearest[i]) && std::isfinite(b.nearest[i]);
    };
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
      if (end - begin >= min_bins && closes(a, begin, end) && closes(b, begin, end)) {
        append_pieces(pair, line, range.begin + begin * kBin, range.begin + end * kBin, side_of(a, begin, end),
                      side_of(b, begin, end), group++, &edges);
      }
      begin = end + 1;
    }
    return edges;
  }

  // The plane really reaches the line; otherwise the two only hang close to each other.
  bool closes(const Support& support, int begin, int end) const {
    std::vector<float> nearest;
    for (int k = begin; k < end; ++k) {
      if (std::isfinite(support.nearest[static_cast<size_t>(k)]))
        nearest.push_back(support.nearest[static_cast<size_t>(k)]);
    }
    int points = 0;
    for (int k = begin; k < end; ++k)
      points += support.left[static_cast<size_t>(k)] + support.right[static_cast<size_t>(k)];
    std::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2), nearest.end());
    // Mean distance between neighbouring points of the strip along its width, were they spread evenly over it.
    const double spacing = options_.support_distance_m * static_cast<double>(nearest.size()) / std::max(1, points);
    return nearest[nearest.size() / 2] < options_.max_gap_m + spacing;
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
      const Fit a = local_fit(pair.first, pair.second, line.direction, middle, length);
      const Fit b = local_fit(pair.second, pair.first, line.direction, middle, length);
      const std::optional<Line> refined = intersect(a.normal, a.centroid, b.normal, b.centroid, middle);
      if (!refined || std::abs(refined->direction.dot(line.direction)) < 0.99) continue;
      if ((refined->point - middle).norm() > options_.max_gap_m + 2.0 * planes_.noise_m) continue;
      const Eigen::Vector3d direction =
          refined->direction.dot(line.direction) > 0 ? refined->direction : Eigen::Vector3d(-refined->direction);
      MapEdge edge;
      edge.start = refined->point - 0.5 * length * direction;
      edge.end = refined->point + 0.5 * length * direction;
      edge.normal_a = a.normal;
      edge.normal_b = b.normal;
      edge.inward_a = side_a * direction.cross(plane(pair.first).normal).normalized();
      edge.inward_b = side_b * direction.cross(plane(pair.second).normal).normalized();
      edge.covariance = covariance_of(a, b, direction);
      edge.group = group;
      edges->push_back(edge);
    }
  }

  // The plane near the edge: its points around the piece, without those within the noise of the other plane.
  Fit local_fit(int32_t id, int32_t other, const Eigen::Vector3d& direction, const Eigen::Vector3d& middle,
                double length) const {
    const MapPlane& p = plane(id);
    const double keep_off = 3.0 * planes_.noise_m;
    const double along = 0.5 * length + 0.5 * options_.fit_distance_m;
    const double reach = std::hypot(along, options_.fit_distance_m) + map_.options().leaf_size_m;
    Moments moments(middle);
    for (const uint32_t leaf : planes_.leaves[static_cast<size_t>(id)]) {
      const uint32_t begin = map_.points_begin(map_.leaf_layer(), leaf);
      if ((map_.point(begin) - middle).squaredNorm() > reach * reach) continue;
      for (uint32_t i = begin; i < map_.points_end(map_.leaf_layer(), leaf); ++i) {
        if (planes_.plane_of_point[i] != id) continue;
        const Eigen::Vector3d x = map_.point(i);
        const double t = direction.dot(x - middle);
        if (std::abs(t) > along || (x - middle - t * direction).norm() > options_.fit_distance_m) continue;
        if (std::abs(plane(other).signed_distance(x)) < keep_off) continue;
        moments.add(x);
      }
    }
    return fit_of(p, moments, direction, middle);
  }

  Fit fit_of(const MapPlane& p, const Moments& moments, const Eigen::Vector3d& direction,
             const Eigen::Vector3d& middle) const {
    Fit fit{p.normal, p.centroid, 0.0};
    double variance = std::max(p.sigma_m * p.sigma_m, 1e-6);
    double effective = static_cast<double>(p.num_points);
    if (moments.count() >= 30) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments.covariance());
      const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
      const double spread = eigen.eigenvalues()(1);  // square metres, the narrower extent of the patch
      // A narrow strip (a door frame) does not hold its own slope: keep the plane's.
      if (spread > 25.0 * eigen.eigenvalues()(0)) {
        fit.normal = normal.dot(p.normal) > 0 ? normal : Eigen::Vector3d(-normal);
      }
      fit.centroid = moments.mean();
      variance = std::max(eigen.eigenvalues()(0), 1e-6);
      effective = static_cast<double>(moments.count());
    }
    // Offset of a fitted plane at distance s from its centroid: sigma^2 / n (1 + s^2 / var(s)).
    const Eigen::Vector3d side = direction.cross(fit.normal);
    const double lever = side.dot(middle - fit.centroid);
    const double extent = moments.count() >= 30 ? std::max(1e-4, side.dot(moments.covariance() * side)) : 0.25;
    fit.offset_variance_at_line = variance / effective * (1.0 + lever * lever / extent);
    return fit;
  }

  // Position errors e of the two planes along their normals move the line by d with normal_a d = e_a, normal_b d = e_b.
  Eigen::Matrix3d covariance_of(const Fit& a, const Fit& b, const Eigen::Vector3d& direction) const {
    Eigen::Matrix3d system;
    system << a.normal.transpose(), b.normal.transpose(), direction.transpose();
    const Eigen::Matrix3d from_errors = system.inverse();
    const double map_variance = options_.map_sigma_m * options_.map_sigma_m;
    const Eigen::Vector3d variances(a.offset_variance_at_line + map_variance, b.offset_variance_at_line + map_variance,
                                    0.0);
    return from_errors * variances.asDiagonal() * from_errors.transpose();
  }

  static constexpr int kMaxGapBins = 2;

  const VoxelMap& map_;
  const PlaneSegmentation& planes_;
  const CreaseEdgeOptions& options_;
  double max_cos_;
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
  return CreaseFinder(map, planes, options).run();
}

}  // namespace cpplus
