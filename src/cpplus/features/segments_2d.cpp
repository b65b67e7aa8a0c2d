#include "cpplus/features/segments_2d.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "cpplus/features/grid_2d.h"

namespace cpplus {
namespace {

struct Line2d {
  Eigen::Vector2d point;
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;
};

class SegmentFinder {
 public:
  SegmentFinder(const std::vector<DirectedPoint2d>& points, const Segment2dOptions& options)
      : points_(points),
        options_(options),
        used_(points.size(), false),
        grid_(positions_of(points), options.max_gap_m) {}

  std::vector<Segment2d> run() {
    std::vector<Segment2d> segments;
    for (uint32_t seed = 0; seed < points_.size(); ++seed) {
      if (!used_[seed]) try_seed(seed, &segments);
    }
    return segments;
  }

 private:
  static std::vector<Eigen::Vector2d> positions_of(const std::vector<DirectedPoint2d>& points) {
    std::vector<Eigen::Vector2d> positions;
    positions.reserve(points.size());
    for (const DirectedPoint2d& p : points) positions.push_back(p.position);
    return positions;
  }

  void try_seed(uint32_t seed, std::vector<Segment2d>* segments) {
    const DirectedPoint2d& s = points_[seed];
    Line2d line{s.position, {-s.normal.y(), s.normal.x()}, s.normal};
    std::vector<std::pair<double, uint32_t>> run;
    // The seed's own normal is rough: start wide and short, end narrow and long.
    double tolerance = 2.0 * options_.tolerance_m;
    double reach = options_.min_length_m;
    for (int round = 0; round < 4; ++round) {
      run = collect(line, s.position, tolerance, reach);
      if (run.size() < kMinPoints) return;
      line = fit(run, line.normal);
      tolerance = options_.tolerance_m;
      reach *= 4.0;
    }
    run = collect(line, s.position, tolerance, 1e9);
    if (run.size() < kMinPoints) return;
    const double length = run.back().first - run.front().first;
    if (length < options_.min_length_m) return;
    for (const auto& item : run) used_[item.second] = true;
    const double origin = line.direction.dot(s.position - line.point);
    segments->push_back({line.point + (origin + run.front().first) * line.direction,
                         line.point + (origin + run.back().first) * line.direction, line.normal});
  }

  // Points on the line, (position along it from the seed, index), ascending: the unbroken run around the seed.
  std::vector<std::pair<double, uint32_t>> collect(const Line2d& line, const Eigen::Vector2d& seed, double tolerance,
                                                   double reach) const {
    std::vector<std::pair<double, uint32_t>> run;
    for (const double sign : {1.0, -1.0}) walk(line, seed, sign, tolerance, reach, &run);
    std::sort(run.begin(), run.end());
    run.erase(std::unique(run.begin(), run.end()), run.end());
    return run;
  }

  void walk(const Line2d& line, const Eigen::Vector2d& seed, double sign, double tolerance, double reach,
            std::vector<std::pair<double, uint32_t>>* run) const {
    double last = 0.0;
    for (double step = 0.0; step - last <= options_.max_gap_m && step <= reach; step += 0.5 * options_.max_gap_m) {
      const Eigen::Vector2d at = seed + sign * step * line.direction;
      grid_.for_each_near(at, 0.5 * options_.max_gap_m, [&](uint32_t i) {
        if (used_[i] || std::abs(line.normal.dot(points_[i].position - line.point)) > tolerance) return;
        if (points_[i].normal.dot(line.normal) < options_.min_normal_cos) return;
        const double t = line.direction.dot(points_[i].position - seed);
        if (sign * t < 0 || sign * t > last + options_.max_gap_m || sign * t > reach) return;
        last = std::max(last, sign * t);
        run->emplace_back(t, i);
      });
    }
  }

  Line2d fit(const std::vector<std::pair<double, uint32_t>>& run, const Eigen::Vector2d& side) const {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto& item : run) mean += points_[item.second].position;
    mean /= static_cast<double>(run.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const auto& item : run) {
      const Eigen::Vector2d d = points_[item.second].position - mean;
      scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
    Eigen::Vector2d normal = eigen.eigenvectors().col(0);
    if (normal.dot(side) < 0) normal = -normal;
    return {mean, {-normal.y(), normal.x()}, normal};
  }

  static constexpr size_t kMinPoints = 6;

  const std::vector<DirectedPoint2d>& points_;
  const Segment2dOptions& options_;
  std::vector<bool> used_;
  Grid2d grid_;
};

}  // namespace

std::vector<Segment2d> find_segments(const std::vector<DirectedPoint2d>& points, const Segment2dOptions& options) {
  if (points.empty()) return {};
  return SegmentFinder(points, options).run();
}

}  // namespace cpplus
