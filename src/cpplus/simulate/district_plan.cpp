#include "cpplus/simulate/district_plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cpplus {
namespace {

using Eigen::Vector2d;

constexpr double kWantedPitch = 64.0;
constexpr double kLane = 1.3;     // of the way, right of the middle of the street
constexpr double kSpacing = 2.0;  // of the way's control points

double heading_of(const Vector2d& step) { return std::atan2(step.y(), step.x()); }

Vector2d right_of(const Vector2d& direction) { return {direction.y(), -direction.x()}; }

/// Crossings at which the way turns.
std::vector<Vector2d> turning_points(const DistrictPlan& plan) {
  std::vector<Vector2d> points;
  const int last = plan.num_streets - 1;
  bool at_end = false;  // of the street
  for (int k = 0; k <= last; ++k, at_end = !at_end) {
    for (const bool is_far : {at_end, !at_end}) points.emplace_back(plan.street_m(is_far ? last : 0), plan.street_m(k));
  }
  // The streets along y begin with the one at whose end the way is.
  const bool from_right = at_end;
  bool at_top = true;
  for (int k = 0; k <= last; ++k, at_top = !at_top) {
    const double x = plan.street_m(from_right ? last - k : k);
    for (const bool is_top : {at_top, !at_top}) points.emplace_back(x, plan.street_m(is_top ? last : 0));
  }
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// The same way on the right-hand lane: each turning point goes to where the lanes meet.
std::vector<Vector2d> on_lane(const std::vector<Vector2d>& points) {
  std::vector<Vector2d> moved;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vector2d before = points[std::max<size_t>(i, 1) - 1];
    const Vector2d after = points[std::min(i + 1, points.size() - 1)];
    Vector2d offset = Vector2d::Zero();
    if (i > 0) offset += right_of((points[i] - before).normalized());
    if (i + 1 < points.size()) offset += right_of((after - points[i]).normalized());
    moved.push_back(points[i] + kLane * offset);
  }
  return moved;
}

}  // namespace

DistrictTile DistrictPlan::tile_at(const Vector2d& position) const {
  const auto index = [&](double x) { return static_cast<int>(std::floor(x / pitch_m + 0.5 * (num_streets - 1))); };
  return {index(position.x()), index(position.y())};
}

double DistrictPlan::distance_m(const DistrictTile& a, const DistrictTile& b) const {
  return pitch_m * std::hypot(std::max(0, std::abs(a.x - b.x) - 1), std::max(0, std::abs(a.y - b.y) - 1));
}

DistrictPlan plan_district(double area_km2, uint64_t seed) {
  const double side_m = 1e3 * std::sqrt(area_km2);
  DistrictPlan plan;
  plan.seed = seed;
  plan.num_streets = std::max(2, static_cast<int>(std::lround(side_m / kWantedPitch)));
  plan.pitch_m = side_m / plan.num_streets;
  return plan;
}

Way district_way(const DistrictPlan& plan) {
  constexpr double kLookEvery = 15.0;  // metres of way
  Way way;
  way.speed_mps = 1.4;
  way.lidar_height_m = 1.75;
  const std::vector<Vector2d> corners = on_lane(turning_points(plan));
  double travelled = 0.0;
  for (size_t leg = 0; leg + 1 < corners.size(); ++leg) {
    const Vector2d step = corners[leg + 1] - corners[leg];
    const int pieces = std::max(1, static_cast<int>(std::lround(step.norm() / kSpacing)));
    for (int i = 0; i < pieces; ++i) {
      const double share = static_cast<double>(i) / pieces;
      const double look = 0.1 + 0.55 * std::sin(2.0 * M_PI * (travelled + share * step.norm()) / kLookEvery);
      way.points.push_back({corners[leg] + share * step, heading_of(step) + look});
    }
    travelled += step.norm();
  }
  way.points.push_back({corners.back(), way.points.back().yaw_rad});
  return way;
}

}  // namespace cpplus
