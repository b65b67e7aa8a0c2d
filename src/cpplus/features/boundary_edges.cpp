#include "cpplus/features/boundary_edges.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "cpplus/core/parallel.h"
#include "cpplus/features/grid_2d.h"
#include "cpplus/features/plane_points.h"
#include "cpplus/features/segments_2d.h"

namespace cpplus {
namespace {

constexpr double kThinCell = 0.03;    // metres
constexpr double kNearRadius = 0.12;  // metres; neighbourhood of a border point
constexpr double kFarRadius = 0.25;   // metres; the same where points are sparse
constexpr size_t kNeighbors = 24;
constexpr double kBin = 0.04;    // metres along an edge
constexpr double kStrip = 0.10;  // metres within an edge
// Points spread at random end one mean spacing inside the border; the width of a LiDAR's beam puts some beyond it.
// Half of the correction leaves either kind of map less than 6 mm off (docs/map_edges.md).
constexpr double kSpacingCorrection = 0.5;

// Neighbours in all eight octants leave less than 90 degrees free: most points of a surface are done with here.
bool all_octants_taken(const Eigen::Vector2d& x, const std::vector<Eigen::Vector2d>& all,
                       const std::vector<std::pair<double, uint32_t>>& neighbors, size_t count) {
  unsigned taken = 0;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d d = all[neighbors[i].second] - x;
    taken |= 1u << ((d.x() < 0) + 2 * (d.y() < 0) + 4 * (std::abs(d.x()) < std::abs(d.y())));
  }
  return taken == 0xFF;
}

// Direction out of the surface when the neighbours of a point leave a wide angle free.
std::optional<Eigen::Vector2d> free_direction(const Eigen::Vector2d& x, const std::vector<Eigen::Vector2d>& all,
                                              std::vector<std::pair<double, uint32_t>>* neighbors,
                                              double min_free_angle) {
  const size_t count = std::min(neighbors->size(), kNeighbors);
  if (count < 6) return std::nullopt;
  const auto last = neighbors->begin() + static_cast<std::ptrdiff_t>(count);
  if (last != neighbors->end()) std::nth_element(neighbors->begin(), last, neighbors->end());
  if (min_free_angle >= 0.5 * std::numbers::pi && all_octants_taken(x, all, *neighbors, count)) return std::nullopt;
  std::vector<double> angles;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d d = all[(*neighbors)[i].second] - x;
    angles.push_back(std::atan2(d.y(), d.x()));
  }
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + 2.0 * std::numbers::pi - angles.back();
  double middle = angles.back() + 0.5 * widest;
  for (size_t i = 1; i < count; ++i) {
    if (angles[i] - angles[i - 1] <= widest) continue;
    widest = angles[i] - angles[i - 1];
    middle = angles[i - 1] + 0.5 * widest;
  }
  if (widest < min_free_angle) return std::nullopt;
  return Eigen::Vector2d(std::cos(middle), std::sin(middle));
}

std::vector<DirectedPoint2d> border_points(const PlanePoints& points, double min_free_angle) {
  std::vector<Eigen::Vector2d> thin;
  for (const uint32_t i : thin_points(points, kThinCell)) thin.push_back(points.positions[i]);
  const Grid2d grid(thin, kNearRadius);
  std::vector<DirectedPoint2d> border;
  std::vector<std::pair<double, uint32_t>> neighbors;
  for (uint32_t i = 0; i < thin.size(); ++i) {
    for (const double radius : {kNearRadius, kFarRadius}) {
      neighbors.clear();
      grid.for_each_near(thin[i], radius, [&](uint32_t k) {
        const double squared = (thin[k] - thin[i]).squaredNorm();
        if (k != i && squared < radius * radius) neighbors.emplace_back(squared, k);
      });
      if (neighbors.size() >= kNeighbors / 2) break;
    }
    if (const auto outward = free_direction(thin[i], thin, &neighbors, min_free_angle))
      border.push_back({thin[i], -*outward});
  }
  return border;
}

struct FittedBorder {
  Eigen::Vector2d start;
  Eigen::Vector2d end;
  Eigen::Vector2d inward;
  double sigma_m;
};

// The outermost points of the raw cloud along a segment, one a bin, corrected for the spacing across the edge.
class BorderFit {
 public:
  BorderFit(const PlanePoints& points, const Grid2d& grid, const Segment2d& segment, const BoundaryEdgeOptions& options)
      : options_(options),
        segment_(segment),
        direction_((segment.end - segment.start).normalized()),
        length_((segment.end - segment.start).norm()) {
    bins_.resize(static_cast<size_t>(std::ceil(length_ / kBin)));
    const Eigen::Vector2d middle = 0.5 * (segment.start + segment.end);
    grid.for_each_near(middle, 0.5 * length_ + 2 * kStrip, [&](uint32_t i) {
      const Eigen::Vector2d d = points.positions[i] - segment.start;
      const double t = direction_.dot(d);
      const double w = segment.normal.dot(d);
      if (t < 0 || t >= length_ || std::abs(w) > 2.0 * kStrip) return;
      bins_[std::min(bins_.size() - 1, static_cast<size_t>(t / kBin))].push_back(w);
    });
  }

  std::optional<FittedBorder> run() {
    std::vector<Eigen::Vector2d> outermost;  // (t, w)
    std::vector<double> spacings;
    for (size_t k = 0; k < bins_.size(); ++k) {
      std::vector<double>& w = bins_[k];
      std::sort(w.begin(), w.end());
      const auto first = std::lower_bound(w.begin(), w.end(), -0.05);
      const auto last = first == w.end() ? first : std::upper_bound(first, w.end(), *first + kStrip);
      if (last - first < 3 || *first > 0.05) continue;
      const double spacing = kStrip / static_cast<double>(last - first);
      spacings.push_back(spacing);
      outermost.emplace_back((static_cast<double>(k) + 0.5) * kBin, *first - kSpacingCorrection * spacing);
    }
    if (outermost.size() < 4 || outermost.size() * 2 < bins_.size()) return std::nullopt;
    std::nth_element(spacings.begin(), spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2),
                     spacings.end());
    if (spacings[spacings.size() / 2] > options_.max_spacing_m) return std::nullopt;
    return fit(outermost);
  }

 private:
  // w = offset + slope * (t - middle), twice: the second time without bins off by more than two deviations.
  std::optional<FittedBorder> fit(const std::vector<Eigen::Vector2d>& samples) const {
    const double middle = 0.5 * length_;
    double offset = 0.0;
    double slope = 0.0;
    double sigma = 0.02;
    size_t used = 0;
    for (int round = 0; round < 3; ++round) {
      double n = 0, st = 0, sw = 0, stt = 0, stw = 0, sww = 0;
      for (const Eigen::Vector2d& s : samples) {
        const double t = s.x() - middle;
        if (round > 0 && std::abs(s.y() - offset - slope * t) > 2.0 * sigma) continue;
        n += 1, st += t, sw += s.y(), stt += t * t, stw += t * s.y(), sww += s.y() * s.y();
      }
      if (n < 4) return std::nullopt;
      const double det = n * stt - st * st;
      slope = det > 1e-9 ? (n * stw - st * sw) / det : 0.0;
      offset = (sw - slope * st) / n;
      const double squares =
          sww - 2 * offset * sw - 2 * slope * stw + n * offset * offset + 2 * offset * slope * st + slope * slope * stt;
      sigma = std::max(0.004, std::sqrt(std::max(0.0, squares / n)));
      used = static_cast<size_t>(n);
    }
    if (sigma > 0.03 || !is_border(offset)) return std::nullopt;
    const Eigen::Vector2d start = segment_.start + (offset - slope * middle) * segment_.normal;
    const Eigen::Vector2d end = segment_.end + (offset + slope * middle) * segment_.normal;
    return FittedBorder{start, end, segment_.normal,
                        std::hypot(sigma / std::sqrt(static_cast<double>(used)), options_.sigma_m)};
  }

  bool is_border(double offset) const {
    size_t outside = 0;
    size_t inside = 0;
    for (const std::vector<double>& w : bins_) {
      for (const double value : w) {
        outside += value < offset - 0.02 && value > offset - 0.02 - kStrip;
        inside += value > offset && value < offset + kStrip;
      }
    }
    return static_cast<double>(outside) <= options_.max_outside_ratio * static_cast<double>(inside);
  }

  const BoundaryEdgeOptions& options_;
  const Segment2d& segment_;
  Eigen::Vector2d direction_;
  double length_;
  std::vector<std::vector<double>> bins_;  // distances of the points from the segment, inward positive
};

std::vector<MapEdge> edges_of_plane(const VoxelMap& map, const PlaneSegmentation& planes, size_t plane,
                                    const BoundaryEdgeOptions& options) {
  const PlanePoints points = plane_points(map, planes, plane);
  const std::vector<DirectedPoint2d> border =
      border_points(points, options.min_free_angle_deg * std::numbers::pi / 180.0);
  Segment2dOptions segment_options;
  segment_options.min_length_m = options.min_length_m;
  const Grid2d grid(points.positions, kStrip);
  std::vector<MapEdge> edges;
  uint32_t group = 0;
  for (const Segment2d& segment : find_segments(border, segment_options)) {
    const int pieces = static_cast<int>(std::ceil((segment.end - segment.start).norm() / options.max_length_m));
    for (int k = 0; k < pieces; ++k) {
      const Eigen::Vector2d step = (segment.end - segment.start) / pieces;
      const Segment2d piece{segment.start + k * step, segment.start + (k + 1) * step, segment.normal};
      const auto fitted = BorderFit(points, grid, piece, options).run();
      if (!fitted) continue;
      MapEdge edge;
      edge.kind = MapEdgeKind::kBoundary;
      edge.start = points.in_map(fitted->start);
      edge.end = points.in_map(fitted->end);
      edge.normal_a = points.normal;
      edge.inward_a = points.direction_in_map(fitted->inward);
      edge.covariance = fitted->sigma_m * fitted->sigma_m * edge.inward_a * edge.inward_a.transpose() +
                        1.6e-5 * points.normal * points.normal.transpose();
      edge.group = group;
      edges.push_back(edge);
    }
    ++group;
  }
  return edges;
}

}  // namespace

void BoundaryEdgeOptions::validate() const {
  check_option(min_length_m > 0, "min_length_m", "(0, inf)", min_length_m);
  check_option(max_length_m > 0, "max_length_m", "(0, inf)", max_length_m);
  check_option(min_free_angle_deg > 0 && min_free_angle_deg < 360, "min_free_angle_deg", "(0, 360)",
               min_free_angle_deg);
  check_option(max_outside_ratio >= 0 && max_outside_ratio <= 1, "max_outside_ratio", "[0, 1]", max_outside_ratio);
  check_option(max_spacing_m > 0, "max_spacing_m", "(0, inf)", max_spacing_m);
  check_option(sigma_m > 0, "sigma_m", "(0, inf)", sigma_m);
}

std::vector<MapEdge> find_boundary_edges(const VoxelMap& map, const PlaneSegmentation& planes,
                                         const BoundaryEdgeOptions& options) {
  options.validate();
  if (!options.enabled) return {};
  std::vector<std::vector<MapEdge>> edges_of(planes.planes.size());
  parallel_for_each(planes.planes.size(), [&](size_t i) { edges_of[i] = edges_of_plane(map, planes, i, options); });
  return concatenate_groups(edges_of);
}

}  // namespace cpplus
