#include "cpplus/simulate/boards_along_way.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "cpplus/simulate/furniture.h"
#include "cpplus/simulate/hash.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/scene_draft.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kInstants = 60;
// Of the plate that add_checkerboard() puts on a tripod, metres.
constexpr double kHalfWidth = 0.45;
constexpr double kHalfHeight = 0.315;
constexpr double kCenterHeight = 0.95 + kHalfHeight;
constexpr double kCenterBeforeFrame = 0.25;

/// A board's middle and the direction that its front faces, horizontal and unit.
struct Place {
  Vector3d center = Vector3d::Zero();
  Vector2d front = Vector2d::UnitX();
};

Vector2d unit(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

/// Poses of the LiDAR evenly over a share of its way.
std::vector<Rigid3> way_poses(const Scene& scene, double first, double last, int count) {
  const Path path(scene.way);
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(path.map_from_lidar(path.duration_s() * (first + (last - first) * i / (count - 1))));
  }
  return poses;
}

/// Images are taken within this part of the way.
std::vector<Rigid3> photographed_way(const Scene& scene) { return way_poses(scene, 0.04, 0.96, kInstants); }

bool free_between(const Tracer& tracer, const Vector3d& from, const Vector3d& to) {
  constexpr double kSlack = 0.02;
  const Vector3d ray = to - from;
  return !tracer.occluded_static(from.cast<float>(), ray.normalized().cast<float>(),
                                 static_cast<float>(ray.norm() - kSlack));
}

/// Whether a camera at a pose of the LiDAR sees a board there well: at 75 degrees over 640 px its squares of 9 cm are
/// then at least 5 px wide.
bool sees_well(const Tracer& tracer, const Rigid3& map_from_lidar, const Place& place) {
  constexpr double kMaxTurn = 0.42;
  constexpr double kMinCosinePerMetre = 0.15;
  constexpr double kNearest = 1.2;
  const Vector3d& eye = map_from_lidar.translation;
  const Vector3d ray = place.center - eye;
  const Vector3d in_lidar = map_from_lidar.rotation.conjugate() * ray;
  const double distance = ray.norm();
  const double cosine = -ray.head<2>().dot(place.front) / distance;
  if (distance < kNearest || cosine < kMinCosinePerMetre * distance) return false;
  if (std::abs(std::atan2(in_lidar.y(), in_lidar.x())) > kMaxTurn) return false;
  const Vector3d along(-kHalfWidth * place.front.y(), kHalfWidth * place.front.x(), 0.0);
  const Vector3d up(0.0, 0.0, kHalfHeight);
  const std::array<Vector3d, 5> points = {place.center, place.center + along + up, place.center + along - up,
                                          place.center - along + up, place.center - along - up};
  return std::all_of(points.begin(), points.end(), [&](const Vector3d& p) { return free_between(tracer, eye, p); });
}

double distance_to_segment(const Vector2d& point, const Vector2d& a, const Vector2d& b) {
  const Vector2d leg = b - a;
  const double share = std::clamp((point - a).dot(leg) / std::max(1e-9, leg.squaredNorm()), 0.0, 1.0);
  return (point - a - share * leg).norm();
}

/// Whether neither the LiDAR on its whole way nor a moving body comes near.
bool out_of_the_way(const Scene& scene, const std::vector<Rigid3>& whole_way, const Vector2d& point) {
  constexpr double kFromLidar = 0.9;
  constexpr double kFromBodies = 1.5;
  for (size_t i = 1; i < whole_way.size(); ++i) {
    const Vector2d a = whole_way[i - 1].translation.head<2>();
    if (distance_to_segment(point, a, whole_way[i].translation.head<2>()) < kFromLidar) return false;
  }
  for (const MovingBody& body : scene.bodies) {
    for (size_t i = 1; i < body.path.size(); ++i) {
      if (distance_to_segment(point, body.path[i - 1].head<2>(), body.path[i].head<2>()) < kFromBodies) return false;
    }
  }
  return true;
}

/// Whether plate and tripod fit: nothing within reach around the middle of the plate nor above the feet.
bool has_room(const Tracer& tracer, const Place& place, double ground_m) {
  constexpr double kReach = 0.6;
  constexpr int kRays = 16;
  for (const double height : {ground_m + 0.2, place.center.z()}) {
    const Vector3d middle(place.center.x(), place.center.y(), height);
    for (int i = 0; i < kRays; ++i) {
      const Vector2d direction = unit(2.0 * M_PI * i / kRays);
      if (tracer.occluded_static(middle.cast<float>(), Vector3d(direction.x(), direction.y(), 0.0).cast<float>(),
                                 static_cast<float>(kReach))) {
        return false;
      }
    }
  }
  return true;
}

/// Places around the way that face it.
std::vector<Place> possible_places(const Tracer& tracer, const std::vector<Rigid3>& way) {
  constexpr int kDirections = 12;
  const std::vector<Rigid3> whole_way = way_poses(tracer.scene(), 0.0, 1.0, 2 * kInstants);
  std::vector<Place> places;
  for (size_t k = 0; k < way.size(); k += 2) {
    const Vector3d& eye = way[k].translation;
    for (int i = 0; i < kDirections; ++i) {
      const Vector2d direction = unit(2.0 * M_PI * i / kDirections);
      for (const double distance : {1.3, 2.0, 3.0, 4.5}) {
        Place place;
        place.front = -direction;
        place.center << eye.head<2>() + distance * direction, eye.z();
        if (!free_between(tracer, eye, place.center)) break;
        const auto floor = tracer.trace_static(place.center.cast<float>(), -Eigen::Vector3f::UnitZ());
        if (!floor) continue;
        place.center.z() = floor->point.z() + kCenterHeight;
        if (!out_of_the_way(tracer.scene(), whole_way, place.center.head<2>())) continue;
        if (has_room(tracer, place, floor->point.z())) places.push_back(place);
      }
    }
  }
  return places;
}

Place place_of(const SceneCheckerboard& board) {
  const Vector3d middle = 0.5 * (board.corners.front() + board.corners.back());
  const Vector3d right = board.corners[1] - board.corners[0];
  const Vector3d down = board.corners.back() - board.corners[static_cast<size_t>(board.inner_columns) - 1];
  return {middle, down.cross(right).head<2>().normalized()};
}

void serve(const Tracer& tracer, const std::vector<Rigid3>& way, const Place& place, std::vector<char>* served) {
  for (size_t i = 0; i < way.size(); ++i) {
    if (!(*served)[i] && sees_well(tracer, way[i], place)) (*served)[i] = 1;
  }
}

/// The place that serves most of the instants which no board of the scene serves; nothing where none serves any.
std::optional<Place> best_place(const Tracer& tracer) {
  const std::vector<Rigid3> way = photographed_way(tracer.scene());
  std::vector<char> served(way.size(), 0);
  for (const SceneCheckerboard& board : tracer.scene().boards) serve(tracer, way, place_of(board), &served);
  std::optional<Place> best;
  auto most = std::count(served.begin(), served.end(), 1);
  for (const Place& place : possible_places(tracer, way)) {
    std::vector<char> now = served;
    serve(tracer, way, place, &now);
    const auto count = std::count(now.begin(), now.end(), 1);
    if (count <= most) continue;
    best = place;
    most = count;
  }
  return best;
}

}  // namespace

void add_boards_along_way(int count, uint64_t seed, Scene* scene) {
  SceneDraft draft("boards", seed);
  draft.scene = std::move(*scene);
  for (int i = 0; i < count; ++i) {
    const std::optional<Place> place = best_place(Tracer(draft.scene));  // a board may hide another one
    if (!place) break;
    const Vector2d behind = place->center.head<2>() - kCenterBeforeFrame * place->front;
    const Vector3d ground(behind.x(), behind.y(), place->center.z() - kCenterHeight);
    const double front_yaw = std::atan2(place->front.y(), place->front.x());
    add_checkerboard(draft, placed_at(ground, front_yaw - 0.5 * M_PI), draft.pick(0.0, 0.15), 0.0);
  }
  *scene = std::move(draft.scene);
}

}  // namespace cpplus
