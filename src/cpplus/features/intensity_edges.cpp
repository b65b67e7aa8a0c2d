#include "cpplus/features/intensity_edges.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "cpplus/core/parallel.h"
#include "cpplus/features/grid_2d.h"
#include "cpplus/features/plane_points.h"
#include "cpplus/features/segments_2d.h"

namespace cpplus {
namespace {

constexpr double kThinCell = 0.03;  // metres
constexpr double kRadius = 0.12;    // metres around a point in which both sides of an edge are compared
constexpr double kStrip = 0.10;     // metres on each side of an edge
// Surroundings in which an edge must stand out, in strips along it.
constexpr double kSurroundings = 0.5;        // metres on each side
constexpr double kSurroundingsStrip = 0.05;  // metres
constexpr double kMinStandOut = 3.0;         // contrast / third quartile of the steps between strips

struct Side {
  double count = 0, sum = 0, squares = 0;
  void add(double value) {
    count += 1;
    sum += value;
    squares += value * value;
  }
  double mean() const { return sum / count; }
  double deviation_sum() const { return std::max(0.0, squares - sum * sum / count); }
};

// Change of intensity between the two sides of a line; 0 where it is not clear.
double contrast_of(const Side& a, const Side& b, const IntensityEdgeOptions& options) {
  if (a.count < 4 || b.count < 4) return 0.0;
  const double difference = std::abs(a.mean() - b.mean());
  const double sigma = std::sqrt((a.deviation_sum() + b.deviation_sum()) / (a.count + b.count));
  if (difference < options.min_contrast * 0.5 * (a.mean() + b.mean())) return 0.0;
  if (difference < options.min_contrast_sigmas * sigma) return 0.0;
  return difference / (sigma + 1e-3 * difference);
}

struct Candidate {
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  // towards the brighter side
  double contrast = 0.0;
};

class IntensityEdgeFinder {
 public:
  IntensityEdgeFinder(const PlanePoints& points, const std::vector<float>& values, const IntensityEdgeOptions& options)
      : points_(points), values_(values), options_(options), grid_(points.positions, 0.5 * kRadius) {}

  std::vector<MapEdge> run() const {
    const std::vector<uint32_t> thin = thin_points(points_, kThinCell);
    std::vector<Eigen::Vector2d> positions;
    std::vector<Candidate> candidates;
    for (const uint32_t i : thin) {
      const Candidate candidate = candidate_at(points_.positions[i]);
      if (candidate.contrast <= 0.0) continue;
      positions.push_back(points_.positions[i]);
      candidates.push_back(candidate);
    }
    Segment2dOptions segment_options;
    segment_options.min_length_m = options_.min_length_m;
    segment_options.tolerance_m = 0.025;
    std::vector<MapEdge> edges;
    uint32_t group = 0;
    for (const Segment2d& segment : find_segments(thin_across(positions, candidates), segment_options)) {
      append_pieces(segment, group++, &edges);
    }
    return edges;
  }

 private:
  // Gradient of a plane fitted to the intensities around x, then both halves of the disc compared.
  Candidate candidate_at(const Eigen::Vector2d& x) const {
    Eigen::Matrix3d system = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    grid_.for_each_near(x, kRadius, [&](uint32_t i) {
      const Eigen::Vector2d d = points_.positions[i] - x;
      if (d.squaredNorm() > kRadius * kRadius) return;
      const Eigen::Vector3d row(d.x(), d.y(), 1.0);
      system += row * row.transpose();
      right += row * static_cast<double>(values_[i]);
    });
    if (system(2, 2) < 12) return {};
    const Eigen::Vector3d fit = system.inverse() * right;
    const Eigen::Vector2d gradient = fit.head<2>();
    if (!gradient.allFinite() || gradient.norm() < 1e-9) return {};
    Candidate candidate;
    candidate.normal = gradient.normalized();
    Side dark;
    Side bright;
    grid_.for_each_near(x, kRadius, [&](uint32_t i) {
      const Eigen::Vector2d d = points_.positions[i] - x;
      if (d.squaredNorm() > kRadius * kRadius) return;
      (candidate.normal.dot(d) < 0 ? dark : bright).add(values_[i]);
    });
    candidate.contrast = contrast_of(dark, bright, options_);
    return candidate;
  }

  // Keeps a candidate when none beside it, across the edge, shows more contrast.
  static std::vector<DirectedPoint2d> thin_across(const std::vector<Eigen::Vector2d>& positions,
                                                  const std::vector<Candidate>& candidates) {
    const Grid2d grid(positions, 0.5 * kRadius);
    std::vector<DirectedPoint2d> kept;
    for (uint32_t i = 0; i < positions.size(); ++i) {
      bool best = true;
      grid.for_each_near(positions[i], 0.5 * kRadius, [&](uint32_t k) {
        const Eigen::Vector2d d = positions[k] - positions[i];
        const double across = std::abs(candidates[i].normal.dot(d));
        if (across > 0.5 * kRadius || d.norm() > 1.5 * across) return;
        best = best && candidates[k].contrast <= candidates[i].contrast;
      });
      if (best) kept.push_back({positions[i], candidates[i].normal});
    }
    return kept;
  }

  void append_pieces(const Segment2d& segment, uint32_t group, std::vector<MapEdge>* edges) const {
    const int pieces = static_cast<int>(std::ceil((segment.end - segment.start).norm() / options_.max_length_m));
    for (int k = 0; k < pieces; ++k) {
      const Eigen::Vector2d step = (segment.end - segment.start) / pieces;
      const Eigen::Vector2d start = segment.start + k * step;
      const auto fitted = fit_piece({start, start + step, segment.normal});
      if (!fitted) continue;
      MapEdge edge;
      edge.kind = MapEdgeKind::kIntensity;
      edge.start = points_.in_map(fitted->start);
      edge.end = points_.in_map(fitted->end);
      edge.normal_a = points_.normal;
      edge.inward_a = points_.direction_in_map(fitted->normal);
      edge.covariance = options_.sigma_m * options_.sigma_m * edge.inward_a * edge.inward_a.transpose() +
                        1.6e-5 * points_.normal * points_.normal.transpose();
      edge.group = group;
      edges->push_back(edge);
    }
  }

  // Turns the piece so that both of its halves lie on the step, then moves all of it there.
  std::optional<Segment2d> fit_piece(Segment2d piece) const {
    const Eigen::Vector2d middle = 0.5 * (piece.start + piece.end);
    const auto first = best_offset(piece.start, middle, piece.normal);
    const auto second = best_offset(middle, piece.end, piece.normal);
    if (first && second) {
      // The halves' middles are half a length apart, the ends a whole one.
      const Eigen::Vector2d turn = (*second - *first) * piece.normal;
      piece.start -= turn;
      piece.end += turn;
      const Eigen::Vector2d along = (piece.end - piece.start).normalized();
      const Eigen::Vector2d normal(-along.y(), along.x());
      piece.normal = normal.dot(piece.normal) > 0 ? normal : Eigen::Vector2d(-normal);
    }
    const auto offset = best_offset(piece.start, piece.end, piece.normal);
    if (!offset) return std::nullopt;
    const Segment2d fitted{piece.start + *offset * piece.normal, piece.end + *offset * piece.normal, piece.normal};
    if (!stands_out(fitted)) return std::nullopt;
    return fitted;
  }

  // Whether the step is large among the steps from strip to strip around it. Lasers of a spinning LiDAR differ in what
  // they measure of one surface: then every ring's border is a step like this one.
  bool stands_out(const Segment2d& piece) const {
    const Eigen::Vector2d middle = 0.5 * (piece.start + piece.end);
    const Eigen::Vector2d direction = (piece.end - piece.start).normalized();
    const double half = 0.5 * (piece.end - piece.start).norm();
    constexpr int kHalfCount = static_cast<int>(kSurroundings / kSurroundingsStrip);
    std::vector<Side> strips(2 * kHalfCount);
    grid_.for_each_near(middle, std::hypot(half, kSurroundings), [&](uint32_t i) {
      const Eigen::Vector2d d = points_.positions[i] - middle;
      const int strip = static_cast<int>(std::floor(piece.normal.dot(d) / kSurroundingsStrip)) + kHalfCount;
      if (std::abs(direction.dot(d)) > half || strip < 0 || strip >= 2 * kHalfCount) return;
      strips[static_cast<size_t>(strip)].add(values_[i]);
    });
    const auto step_after = [&](size_t k) -> std::optional<double> {
      if (strips[k].count < 4 || strips[k + 1].count < 4) return std::nullopt;
      return std::abs(strips[k + 1].mean() - strips[k].mean());
    };
    std::vector<double> steps;
    for (size_t k = 0; k + 1 < strips.size(); ++k) {
      const auto step = step_after(k);
      if (step && k + 1 != kHalfCount) steps.push_back(*step);
    }
    const auto own = step_after(kHalfCount - 1);
    if (!own || steps.size() < 6) return true;
    // Not the median: stripes wider than a strip have no step at every other strip.
    const auto quartile = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() * 3 / 4);
    std::nth_element(steps.begin(), quartile, steps.end());
    return *own >= kMinStandOut * *quartile;
  }

  // The step that explains the raw intensities best: least squares of two levels over all positions of the step.
  std::optional<double> best_offset(const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                                    const Eigen::Vector2d& normal) const {
    const Eigen::Vector2d middle = 0.5 * (start + end);
    const Eigen::Vector2d direction = (end - start).normalized();
    const double half = 0.5 * (end - start).norm();
    std::vector<std::pair<double, double>> samples;  // (distance, intensity)
    Side all;
    grid_.for_each_near(middle, half + kStrip, [&](uint32_t i) {
      const Eigen::Vector2d d = points_.positions[i] - middle;
      const double w = normal.dot(d);
      if (std::abs(direction.dot(d)) > half || std::abs(w) > kStrip) return;
      samples.emplace_back(w, values_[i]);
      all.add(values_[i]);
    });
    if (samples.size() < 20) return std::nullopt;
    std::sort(samples.begin(), samples.end());
    Side dark;
    double best_cost = all.deviation_sum();
    std::optional<double> best;
    Side best_dark;
    for (size_t k = 0; k + 1 < samples.size(); ++k) {
      dark.add(samples[k].second);
      if (std::abs(samples[k].first) > 0.6 * kStrip) continue;
      const Side bright{all.count - dark.count, all.sum - dark.sum, all.squares - dark.squares};
      const double cost = dark.deviation_sum() + bright.deviation_sum();
      if (cost >= best_cost) continue;
      best_cost = cost;
      best = 0.5 * (samples[k].first + samples[k + 1].first);
      best_dark = dark;
    }
    if (!best) return std::nullopt;
    const Side bright{all.count - best_dark.count, all.sum - best_dark.sum, all.squares - best_dark.squares};
    if (contrast_of(best_dark, bright, options_) <= 0.0) return std::nullopt;
    return best;
  }

  const PlanePoints& points_;
  const std::vector<float>& values_;
  const IntensityEdgeOptions& options_;
  Grid2d grid_;
};

}  // namespace

void IntensityEdgeOptions::validate() const {
  check_option(min_length_m > 0, "min_length_m", "(0, inf)", min_length_m);
  check_option(max_length_m > 0, "max_length_m", "(0, inf)", max_length_m);
  check_option(min_contrast > 0 && min_contrast < 2, "min_contrast", "(0, 2)", min_contrast);
  check_option(min_contrast_sigmas > 0, "min_contrast_sigmas", "(0, inf)", min_contrast_sigmas);
  check_option(sigma_m > 0, "sigma_m", "(0, inf)", sigma_m);
}

std::vector<MapEdge> find_intensity_edges(const VoxelMap& map, std::span<const float> intensities,
                                          const PlaneSegmentation& planes, const IntensityEdgeOptions& options) {
  options.validate();
  if (!options.enabled || intensities.empty()) return {};
  std::vector<std::vector<MapEdge>> edges_of(planes.planes.size());
  parallel_for_each(planes.planes.size(), [&](size_t i) {
    const PlanePoints points = plane_points(map, planes, i);
    std::vector<float> values;
    values.reserve(points.indices.size());
    for (const uint32_t index : points.indices) values.push_back(intensities[index]);
    edges_of[i] = IntensityEdgeFinder(points, values, options).run();
  });
  return concatenate_groups(edges_of);
}

}  // namespace cpplus
