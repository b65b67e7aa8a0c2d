#include "cpplus/features/local_plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "cpplus/cloud/moments.h"

namespace cpplus {
namespace {

constexpr size_t kMinPoints = 30;
constexpr double kCell = 0.2;          // metres; errors of points in one cell are not independent
constexpr double kMaxSlope = 0.1;      // rad, beyond what noise explains
constexpr double kMaxRoughness = 3.0;  // RMS distance from the plane in units of the map's noise
constexpr double kSignificance = 3.0;  // standard deviations
constexpr double kStrip = 0.02;        // metres; width of the strips along the line whose means are compared
constexpr double kMinStep = 0.005;     // metres; smaller steps are within what maps are bent
constexpr int kMaxRounds = 4;
constexpr double kNormalSigma = 0.005;  // rad, of a narrow strip that takes its normal from the plane beyond it

// Points of the plane around the piece, off the other plane.
std::vector<Eigen::Vector3d> points_near(const VoxelMap& map, const PlaneSegmentation& planes, int32_t id,
                                         int32_t other, const LinePiece& piece, double distance) {
  const double keep_off = kSignificance * planes.noise_m;
  const double along = 0.5 * piece.length + 0.5 * distance;
  const double reach = std::hypot(along, distance) + map.options().leaf_size_m * std::sqrt(3.0);
  const MapPlane& other_plane = planes.planes[static_cast<size_t>(other)];
  std::vector<Eigen::Vector3d> points;
  for (const uint32_t leaf : planes.leaves[static_cast<size_t>(id)]) {
    const uint32_t begin = map.points_begin(map.leaf_layer(), leaf);
    if ((map.point(begin) - piece.middle).squaredNorm() > reach * reach) continue;
    for (uint32_t i = begin; i < map.points_end(map.leaf_layer(), leaf); ++i) {
      if (planes.plane_of_point[i] != id) continue;
      const Eigen::Vector3d x = map.point(i);
      const double t = piece.direction.dot(x - piece.middle);
      if (std::abs(t) > along || (x - piece.middle - t * piece.direction).norm() > distance) continue;
      if (std::abs(other_plane.signed_distance(x)) < keep_off) continue;
      points.push_back(x);
    }
  }
  return points;
}

// A point as seen along the piece.
struct Sample {
  Eigen::Vector3d x;
  double along;
  double from_line;
};

std::vector<Sample> samples_of(const std::vector<Eigen::Vector3d>& points, const LinePiece& piece) {
  std::vector<Sample> samples;
  samples.reserve(points.size());
  for (const Eigen::Vector3d& x : points) {
    const Eigen::Vector3d d = x - piece.middle;
    const double along = piece.direction.dot(d);
    samples.push_back({x, along, (d - along * piece.direction).norm()});
  }
  return samples;
}

// The plane through the samples from `begin` to `end` metres from the line.
class LocalFit {
 public:
  LocalFit(const std::vector<Sample>& samples, const Eigen::Vector3d& normal, const LinePiece& piece, double begin,
           double end)
      : samples_(samples), piece_(piece), begin_(begin), end_(end), moments_(piece.middle), fit_{normal, {}, 0.0} {
    for (const Sample& sample : samples) {
      if (holds(sample)) moments_.add(sample.x);
    }
    if (!has_points()) return;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments_.covariance());
    fit_.centroid = moments_.mean();
    // A narrow strip (a door frame) does not hold its own slope: keep the plane's.
    has_own_normal_ = eigen.eigenvalues()(1) > 25.0 * eigen.eigenvalues()(0);
    if (has_own_normal_) {
      const Eigen::Vector3d own = eigen.eigenvectors().col(0);
      fit_.normal = own.dot(normal) > 0 ? own : Eigen::Vector3d(-own);
    }
    set_variance();
  }

  bool has_points() const { return moments_.count() >= kMinPoints; }
  const LocalPlane& fit() const { return fit_; }
  double sigma() const { return sigma_; }
  double distance_of(const Sample& sample) const { return fit_.normal.dot(sample.x - fit_.centroid); }
  bool holds(const Sample& sample) const { return sample.from_line >= begin_ && sample.from_line <= end_; }

  // Of the points up to a third of the distance.
  bool near_points_agree(double noise_m) const {
    double n = 0, s = 0, ss = 0, w = 0, sw = 0, ww = 0;
    for (const Sample& sample : samples_) {
      const double from = sample.from_line;
      if (from > end_ / 3.0) continue;
      const double distance = distance_of(sample);
      n += 1, s += from, ss += from * from, w += distance, sw += from * distance, ww += distance * distance;
    }
    if (n < 10) return true;
    const double spread = ss / n - s * s / n / n;
    const double slope = (sw / n - s * w / n / n) / std::max(spread, 1e-8);
    const double sigma = std::sqrt(std::max(0.0, ww / n - w * w / n / n));
    const double slope_sigma = sigma / std::sqrt(n * std::max(spread, 1e-8));
    if (sigma > kMaxRoughness * noise_m) return false;
    if (std::abs(slope) > kMaxSlope + kSignificance * slope_sigma) return false;
    return std::abs(w / n) < 0.25 * noise_m + kSignificance * sigma / std::sqrt(n);
  }

 private:
  // Variance of the mean distance, from the means of cells: the noise of a map is not independent from point to point.
  // The offset of a fitted plane at distance s from its centroid has 1 + s^2 / var(s) times that.
  void set_variance() {
    const Eigen::Vector3d side = piece_.direction.cross(fit_.normal);
    struct Cell {
      double count = 0, sum = 0;
    };
    std::map<std::pair<int, int>, Cell> cells;
    double squares = 0.0;
    for (const Sample& sample : samples_) {
      if (!holds(sample)) continue;
      const double distance = distance_of(sample);
      Cell& cell = cells[{static_cast<int>(std::floor(sample.along / kCell)),
                          static_cast<int>(std::floor(side.dot(sample.x - piece_.middle) / kCell))}];
      cell.count += 1;
      cell.sum += distance;
      squares += distance * distance;
    }
    const double n = static_cast<double>(moments_.count());
    sigma_ = std::sqrt(squares / n);
    double variance = std::max(squares, 1e-6) / (n * n);
    double of_cells = 0.0;
    for (const auto& [key, cell] : cells) of_cells += cell.sum * cell.sum;
    variance = std::max(variance, of_cells / (n * n));
    const double lever = side.dot(piece_.middle - fit_.centroid);
    const double extent = std::max(1e-4, side.dot(moments_.covariance() * side));
    fit_.offset_variance = has_own_normal_ ? variance * (1.0 + lever * lever / extent)
                                           : variance + kNormalSigma * kNormalSigma * lever * lever;
  }

  const std::vector<Sample>& samples_;
  const LinePiece& piece_;
  double begin_;
  double end_;
  Moments moments_;
  LocalPlane fit_;
  bool has_own_normal_ = false;
  double sigma_ = 0.0;
};

// How far from the line the surface steps, if it does: relief below the noise of a point (a skirting board) shows in
// the means of strips along the line. Nothing where a parabola explains the strips as well: that surface is curved.
std::optional<double> step_from_line(const std::vector<Sample>& samples, const LocalFit& fit, double end) {
  struct Sums {
    double n = 0, w = 0;
  };
  std::vector<Sums> strips(static_cast<size_t>(std::ceil(end / kStrip)) + 1);
  Sums all;
  double ww = 0.0;
  for (const Sample& sample : samples) {
    if (!fit.holds(sample)) continue;
    const double w = fit.distance_of(sample);
    Sums& strip = strips[static_cast<size_t>(sample.from_line / kStrip)];
    strip.n += 1, strip.w += w;
    all.n += 1, all.w += w;
    ww += w * w;
  }
  const double variance = ww / all.n - all.w * all.w / all.n / all.n;
  double best_gain = 0.0;
  double best = 0.0;
  double best_step = 0.0;
  Sums near;
  for (size_t k = 0; k + 1 < strips.size(); ++k) {
    near.n += strips[k].n, near.w += strips[k].w;
    const Sums far{all.n - near.n, all.w - near.w};
    if (near.n < kMinPoints || far.n < kMinPoints) continue;
    const double step = near.w / near.n - far.w / far.n;
    const double gain = near.n * far.n / all.n * step * step;
    if (gain <= best_gain) continue;
    best_gain = gain;
    best_step = step;
    // Without the last strip, where there are others: the step may lie in it.
    best = static_cast<double>(near.n - strips[k].n < kMinPoints ? k + 1 : k) * kStrip;
  }
  constexpr double kStepSignificance = 5.0;  // standard deviations; the best of many places is looked at
  if (best_gain < kStepSignificance * kStepSignificance * variance || std::abs(best_step) < kMinStep)
    return std::nullopt;
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < strips.size(); ++k) {
    const double s = (static_cast<double>(k) + 0.5) * kStrip / end;
    const Eigen::Vector3d powers(1.0, s, s * s);
    normal_matrix += strips[k].n * powers * powers.transpose();
    right += strips[k].w * powers;
  }
  const double parabola_gain = right.dot(normal_matrix.ldlt().solve(right)) - all.w * all.w / all.n;
  if (parabola_gain > best_gain) return std::nullopt;
  return best;
}

}  // namespace

std::optional<LocalPlane> fit_local_plane(const VoxelMap& map, const PlaneSegmentation& planes, int32_t id,
                                          int32_t other, const LinePiece& piece, double fit_distance_m) {
  const std::vector<Sample> samples = samples_of(points_near(map, planes, id, other, piece, fit_distance_m), piece);
  const MapPlane& plane = planes.planes[static_cast<size_t>(id)];
  const double noise_m = std::max(plane.sigma_m, planes.noise_m);
  Eigen::Vector3d normal = plane.normal;
  double end = fit_distance_m;
  for (int round = 0; round < kMaxRounds; ++round) {
    const LocalFit fit(samples, normal, piece, 0.0, end);
    if (!fit.has_points()) return std::nullopt;
    if (const std::optional<double> step = step_from_line(samples, fit, end)) {
      const LocalFit beyond(samples, normal, piece, *step, end);
      if (beyond.has_points()) normal = beyond.fit().normal;
      end = *step;
      continue;
    }
    if (fit.near_points_agree(noise_m)) return fit.fit();
    end *= 0.5;
  }
  return std::nullopt;
}

}  // namespace cpplus
