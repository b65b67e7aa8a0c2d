#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/simulate/furniture.h"
#include "cpplus/simulate/room.h"
#include "cpplus/simulate/scene_builders.h"
#include "cpplus/simulate/traffic.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWall = 0.14;
constexpr double kDoorWidth = 0.95;
constexpr double kNoLeaf = std::numeric_limits<double>::quiet_NaN();

/// The floor plan: a corridor along x with rooms on both sides, all inside one rectangle.
struct Plan {
  double corridor_width = 1.9;
  double length = 0.0;
  double height = 2.75;
  std::vector<Room> south;  // their doors are in wall 2 (north)
  std::vector<Room> north;  // their doors are in wall 0 (south)
  double south_depth = 5.0;
  double north_depth = 5.0;
};

std::vector<double> partition(SceneDraft& draft, double length, int count) {
  std::vector<double> borders = {0.0};
  for (int i = 1; i < count; ++i) borders.push_back(length * (i + draft.pick(-0.1, 0.1)) / count);
  borders.push_back(length);
  return borders;
}

/// y = 0 is the corridor's south face, y = corridor_width its north face.
Plan make_plan(SceneDraft& draft) {
  Plan plan;
  plan.length = draft.pick(15.0, 18.0);
  plan.corridor_width = draft.pick(1.8, 2.3);
  plan.height = draft.pick(2.6, 3.0);
  plan.south_depth = draft.pick(4.8, 5.6);
  plan.north_depth = draft.pick(4.8, 5.6);
  for (const bool is_south : {true, false}) {
    const auto borders = partition(draft, plan.length, is_south ? 3 : 2);
    for (size_t i = 0; i + 1 < borders.size(); ++i) {
      Room room;
      room.height_m = plan.height;
      room.low.x() = borders[i] + (i == 0 ? 0.0 : 0.5 * kWall);
      room.high.x() = borders[i + 1] - (i + 2 == borders.size() ? 0.0 : 0.5 * kWall);
      room.low.y() = is_south ? -kWall - plan.south_depth : plan.corridor_width + kWall;
      room.high.y() = is_south ? -kWall : plan.corridor_width + kWall + plan.north_depth;
      const double width = room.high.x() - room.low.x();
      const double door = draft.pick(0.25, 0.7) * (width - 2.5) + 0.8;
      room.openings[is_south ? 2 : 0] = {{door, door + kDoorWidth, 0.0, 2.05}};
      const double window = draft.pick(0.3, 0.5) * (width - 1.8);
      room.openings[is_south ? 0 : 2] = {{window, window + draft.pick(1.3, 1.8), 0.95, 2.1}};
      (is_south ? plan.south : plan.north).push_back(room);
    }
  }
  return plan;
}

Vector2d door_center(const Room& room, bool is_south) {
  const auto ends = room.wall(is_south ? 2 : 0);
  const WallOpening& door = room.openings[is_south ? 2 : 0][0];
  return ends[0] + (ends[1] - ends[0]).normalized() * 0.5 * (door.begin_m + door.end_m);
}

WallStyle wall_style(SceneDraft& draft, const Plan& plan, uint32_t trim) {
  WallStyle style;
  style.height_m = plan.height;
  style.thickness_m = kWall;
  style.trim = trim;
  style.material = draft.material(draft.chance(0.25) ? Pattern::kConcrete : Pattern::kPlaster, draft.pick_paint(),
                                  {0.2f, 0.2f, 0.2f});
  return style;
}

/// Walls of the corridor with all doors, party walls between rooms, outer walls with windows.
void build_walls(SceneDraft& draft, const Plan& plan) {
  const uint32_t trim = draft.material(Pattern::kWood, {0.30f, 0.22f, 0.15f}, {0.2f, 0.13f, 0.08f});
  for (const bool is_south : {true, false}) {
    const auto& rooms = is_south ? plan.south : plan.north;
    std::vector<WallOpening> doors;
    for (const Room& room : rooms) {
      WallOpening door = room.openings[is_south ? 2 : 0][0];
      const double center = door_center(room, is_south).x();
      // The corridor's wall runs with the corridor on its left: +x in the south, -x in the north.
      const double along = is_south ? center : plan.length - center;
      door.begin_m = along - 0.5 * kDoorWidth;
      door.end_m = along + 0.5 * kDoorWidth;
      doors.push_back(door);
    }
    std::sort(doors.begin(), doors.end(), [](const auto& a, const auto& b) { return a.begin_m < b.begin_m; });
    WallStyle style = wall_style(draft, plan, trim);
    style.skirting_right = true;
    const Vector2d a = is_south ? Vector2d(0.0, 0.0) : Vector2d(plan.length, plan.corridor_width);
    const Vector2d b = is_south ? Vector2d(plan.length, 0.0) : Vector2d(0.0, plan.corridor_width);
    add_wall(draft, a, b, doors, style);
    for (const WallOpening& door : doors) {
      add_door(draft, wall_frame(a, b), door, kWall, draft.chance(0.3) ? kNoLeaf : -draft.pick(1.2, 1.9));
    }
    for (size_t i = 0; i < rooms.size(); ++i) {
      const Room& room = rooms[i];
      const int outer = is_south ? 0 : 2;
      style = wall_style(draft, plan, trim);
      const auto ends = room.wall(outer);
      add_wall(draft, ends[0], ends[1], room.openings[static_cast<size_t>(outer)], style);
      add_window(draft, wall_frame(ends[0], ends[1]), room.openings[static_cast<size_t>(outer)][0], kWall);
      const auto east = room.wall(1);
      style = wall_style(draft, plan, trim);
      style.skirting_right = i + 1 < rooms.size();
      add_wall(draft, east[0], east[1], {}, style);
      if (i == 0) {
        const auto west = room.wall(3);
        style.skirting_right = false;
        add_wall(draft, west[0], west[1], {}, style);
      }
    }
  }
  WallStyle end_style = wall_style(draft, plan, trim);
  add_wall(draft, {plan.length, 0.0}, {plan.length, plan.corridor_width}, {}, end_style);
  add_wall(draft, {0.0, plan.corridor_width}, {0.0, 0.0}, {}, end_style);
}

void build_slabs(SceneDraft& draft, const Plan& plan) {
  const uint32_t corridor_floor =
      draft.material(Pattern::kTiles, draft.pick_muted(0.3f, 0.5f), {0.12f, 0.12f, 0.12f}, 0.4f);
  const uint32_t ceiling = draft.material(Pattern::kCeilingPanel, {0.65f, 0.65f, 0.63f}, {0.3f, 0.3f, 0.3f}, 0.6f);
  add_floor(draft, {-kWall, 0.0}, {plan.length + kWall, plan.corridor_width}, corridor_floor);
  for (const bool is_south : {true, false}) {
    const Eigen::Vector3f color = draft.pick_muted(0.2f, 0.45f);
    const uint32_t floor = draft.chance(0.5)
                               ? draft.material(Pattern::kCarpet, color, 0.75f * color, 0.5f)
                               : draft.material(Pattern::kPlanks, {0.45f, 0.30f, 0.17f}, {0.3f, 0.19f, 0.1f}, 0.14f);
    const double low = is_south ? -2.0 * kWall - plan.south_depth : plan.corridor_width;
    const double high = is_south ? 0.0 : plan.corridor_width + 2.0 * kWall + plan.north_depth;
    add_floor(draft, {-kWall, low}, {plan.length + kWall, high}, floor);
  }
  add_ceiling(draft, {-kWall, -2.0 * kWall - plan.south_depth},
              {plan.length + kWall, plan.corridor_width + 2.0 * kWall + plan.north_depth}, plan.height, ceiling);
}

/// Into a room, around half of its table, and out again; points 0.5 m or so apart.
void append_visit(const Room& room, bool is_south, std::vector<Vector2d>* route) {
  const Vector2d door = door_center(room, is_south);
  const double inward = is_south ? -1.0 : 1.0;
  const Vector2d half = 0.5 * (room.high - room.low);
  const Vector2d inside = door + Vector2d(0.0, 1.1 * inward);
  route->push_back(door + Vector2d(0.0, -0.7 * inward));
  route->push_back(door);
  route->push_back(inside);
  const double side = door.x() < room.center().x() ? 1.0 : -1.0;
  const double reach_x = std::max(0.6, half.x() - 1.4);
  const double reach_y = std::max(0.6, half.y() - 1.35);
  for (const double angle : {-0.9, -0.35, 0.2, 0.8, 1.4}) {
    route->push_back(room.center() + Vector2d(side * reach_x * std::cos(angle), inward * reach_y * std::sin(angle)));
  }
}

/// Even steps along a polyline with headings along it, smoothed by the spline of Path.
std::vector<WayPoint> way_points(const std::vector<Vector2d>& route, double step_m) {
  std::vector<WayPoint> points;
  for (size_t i = 0; i + 1 < route.size(); ++i) {
    const Vector2d leg = route[i + 1] - route[i];
    const int steps = std::max(1, static_cast<int>(leg.norm() / step_m));
    for (int k = 0; k < steps; ++k) points.push_back({route[i] + leg * k / steps, std::atan2(leg.y(), leg.x())});
  }
  return points;
}

}  // namespace

Scene build_rooms(uint64_t seed) {
  SceneDraft draft("rooms", seed);
  const Plan plan = make_plan(draft);
  build_slabs(draft, plan);
  build_walls(draft, plan);
  for (const bool is_south : {true, false}) {
    for (const Room& room : is_south ? plan.south : plan.north) {
      FurnishOptions furnish;
      furnish.boards = draft.chance(0.5) ? 1 : 0;
      furnish.rug = draft.chance(0.5);
      furnish_room(draft, room, furnish);
      if (draft.chance(0.6)) add_structure(draft, room);
      for (const double y : {0.25, 0.75}) {
        add_ceiling_lamp(draft,
                         {room.center().x(), room.low.y() + y * (room.high.y() - room.low.y()), plan.height - 0.06},
                         0.0, 1.2, 0.3, 6.0f);
      }
    }
  }
  const int lamps = static_cast<int>(plan.length / 4.0);
  for (int i = 0; i < lamps; ++i) {
    add_ceiling_lamp(draft, {plan.length * (i + 0.5) / lamps, 0.5 * plan.corridor_width, plan.height - 0.06}, 0.0, 1.2,
                     0.25, 5.0f);
  }
  std::vector<Vector2d> route;
  const double middle = 0.5 * plan.corridor_width;
  append_visit(plan.south.front(), true, &route);
  std::reverse(route.begin(), route.end());
  route.push_back(door_center(plan.south.front(), true) + Vector2d(1.0, middle));
  route.push_back(door_center(plan.north.back(), false) + Vector2d(-1.0, -middle));
  append_visit(plan.north.back(), false, &route);
  draft.scene.way.points = way_points(route, 0.6);
  draft.scene.way.speed_mps = 0.9;

  const double y = 0.24 * plan.corridor_width;
  add_walking_person(draft, {{1.0, y, 0.0}, {plan.length - 1.0, y, 0.0}}, draft.pick(0.9, 1.3), draft.pick(0.0, 10.0));
  add_walking_person(draft, {{plan.length - 0.8, plan.corridor_width - y, 0.0}, {1.2, plan.corridor_width - y, 0.0}},
                     draft.pick(0.8, 1.2), draft.pick(0.0, 10.0));
  const Room& visited = plan.north.back();
  const double walk_y = visited.low.y() + 0.95;
  add_walking_person(draft, {{visited.low.x() + 1.0, walk_y, 0.0}, {visited.high.x() - 1.0, walk_y, 0.0}},
                     draft.pick(0.5, 0.8), 0.0);

  draft.scene.sky.sun_direction =
      Eigen::Vector3f(static_cast<float>(draft.pick(-0.6, 0.6)), -1.0f, static_cast<float>(draft.pick(0.5, 0.9)))
          .normalized();
  draft.scene.sky.sun_irradiance = {9.0f, 8.5f, 7.5f};
  draft.scene.sky.ambient = Eigen::Vector3f::Constant(0.45f);
  draft.scene.sky.ambient_reach_m = 1.2f;
  return draft.scene;
}

}  // namespace cpplus
