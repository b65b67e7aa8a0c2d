#include "cpplus/features/local_plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "cpplus/features/moments.h"

namespace cpplus {
namespace {

constexpr size_t kMinPoints = 30;
constexpr double kCell = 0.2;          // metres; errors of points in one cell are not independent
constexpr double kMaxSlope = 0.1;      // rad, beyond what noise explains
constexpr double kMaxRoughness = 3.0;  // RMS distance from the plane in units of the map's noise
constexpr double kSignificance = 3.0;  // standard deviations

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

class LocalFit {
 public:
  LocalFit(const std::vector<Eigen::Vector3d>& points, const MapPlane& plane, const LinePiece& piece, double distance)
      : points_(points), piece_(piece), distance_(distance), moments_(piece.middle), fit_{plane.normal, {}, 0.0} {
    for (const Eigen::Vector3d& x : points) {
      if (from_line(x) <= distance) moments_.add(x);
    }
    if (moments_.count() < kMinPoints) {
      fit_.centroid = plane.centroid;
      return;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments_.covariance());
    fit_.centroid = moments_.mean();
    // A narrow strip (a door frame) does not hold its own slope: keep the plane's.
    if (eigen.eigenvalues()(1) > 25.0 * eigen.eigenvalues()(0)) {
      const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
      fit_.normal = normal.dot(plane.normal) > 0 ? normal : Eigen::Vector3d(-normal);
    }
    set_variance();
  }

  bool has_points() const { return moments_.count() >= kMinPoints; }
  const LocalPlane& fit() const { return fit_; }
  double sigma() const { return sigma_; }

  // Of the points up to a third of the distance.
  bool near_points_agree(double noise_m) const {
    double n = 0, s = 0, ss = 0, w = 0, sw = 0, ww = 0;
    for (const Eigen::Vector3d& x : points_) {
      const double from = from_line(x);
      if (from > distance_ / 3.0) continue;
      const double distance = fit_.normal.dot(x - fit_.centroid);
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
  double from_line(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d d = x - piece_.middle;
    return (d - piece_.direction.dot(d) * piece_.direction).norm();
  }

  // Variance of the mean distance, from the means of cells: the noise of a map is not independent from point to point.
  // The offset of a fitted plane at distance s from its centroid has 1 + s^2 / var(s) times that.
  void set_variance() {
    const Eigen::Vector3d side = piece_.direction.cross(fit_.normal);
    struct Cell {
      double count = 0, sum = 0;
    };
    std::map<std::pair<int, int>, Cell> cells;
    double squares = 0.0;
    for (const Eigen::Vector3d& x : points_) {
      if (from_line(x) > distance_) continue;
      const Eigen::Vector3d d = x - piece_.middle;
      const double distance = fit_.normal.dot(x - fit_.centroid);
      Cell& cell = cells[{static_cast<int>(std::floor(piece_.direction.dot(d) / kCell)),
                          static_cast<int>(std::floor(side.dot(d) / kCell))}];
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
    fit_.offset_variance = variance * (1.0 + lever * lever / extent);
  }

  const std::vector<Eigen::Vector3d>& points_;
  const LinePiece& piece_;
  double distance_;
  Moments moments_;
  LocalPlane fit_;
  double sigma_ = 0.0;
};

}  // namespace

std::optional<LocalPlane> fit_local_plane(const VoxelMap& map, const PlaneSegmentation& planes, int32_t id,
                                          int32_t other, const LinePiece& piece, double fit_distance_m) {
  const std::vector<Eigen::Vector3d> points = points_near(map, planes, id, other, piece, fit_distance_m);
  const MapPlane& plane = planes.planes[static_cast<size_t>(id)];
  for (const double distance : {fit_distance_m, 0.5 * fit_distance_m}) {
    const LocalFit fit(points, plane, piece, distance);
    if (!fit.has_points()) return std::nullopt;
    if (fit.near_points_agree(planes.noise_m)) return fit.fit();
  }
  return std::nullopt;
}

}  // namespace cpplus
