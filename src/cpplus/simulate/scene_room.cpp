#include <algorithm>
#include <cmath>
#include <limits>

#include "cpplus/simulate/furniture.h"
#include "cpplus/simulate/room.h"
#include "cpplus/simulate/scene_builders.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Once around the table, looking ahead and across the room in turns.
Way way_around(SceneDraft& draft, const Room& room) {
  Way way;
  const Vector2d half = 0.5 * (room.high - room.low) - Vector2d::Constant(1.35);
  const double start = draft.pick(0.0, 2.0 * M_PI);
  constexpr int kPoints = 16;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = start + 1.7 * M_PI * i / kPoints;
    const Vector2d offset(half.x() * std::cos(angle), half.y() * std::sin(angle));
    const Vector2d tangent(-half.x() * std::sin(angle), half.y() * std::cos(angle));
    const double glance = 0.6 + 0.6 * std::sin(3.0 * angle);
    way.points.push_back({room.center() + offset, std::atan2(tangent.y(), tangent.x()) + glance});
  }
  way.speed_mps = 0.7;
  return way;
}

}  // namespace

Scene build_room(uint64_t seed) {
  SceneDraft draft("room", seed);
  Room room;
  room.high = Vector2d(draft.pick(6.5, 8.5), draft.pick(5.5, 7.0));
  room.height_m = draft.pick(2.7, 3.2);
  const double door = draft.pick(0.8, 1.5);
  room.openings[0] = {{door, door + 0.9, 0.0, 2.05}};
  const double window = draft.pick(1.0, 2.0);
  room.openings[1] = {{window, window + draft.pick(1.2, 1.8), 0.95, 2.1}};

  const bool tiled = draft.chance(0.5);
  const Eigen::Vector3f floor_color = draft.pick_muted(0.2f, 0.45f);
  const uint32_t floor = draft.material(
      tiled ? Pattern::kTiles : Pattern::kCarpet, floor_color,
      tiled ? Eigen::Vector3f(0.3f * floor_color) : Eigen::Vector3f(0.75f * floor_color), tiled ? 0.45f : 0.5f);
  const uint32_t ceiling = draft.material(Pattern::kCeilingPanel, {0.65f, 0.65f, 0.63f}, {0.3f, 0.3f, 0.3f}, 0.6f);
  const Vector2d margin(0.2, 0.2);
  add_floor(draft, room.low - margin, room.high + margin, floor);
  add_ceiling(draft, room.low - margin, room.high + margin, room.height_m, ceiling);

  WallStyle style;
  style.height_m = room.height_m;
  style.thickness_m = 0.2;
  style.trim = draft.material(Pattern::kWood, {0.3f, 0.2f, 0.12f}, {0.2f, 0.12f, 0.07f});
  for (int side = 0; side < 4; ++side) {
    style.material = draft.material(draft.chance(0.3) ? Pattern::kConcrete : Pattern::kPlaster, draft.pick_paint(),
                                    {0.2f, 0.2f, 0.2f});
    const auto ends = room.wall(side);
    add_wall(draft, ends[0], ends[1], room.openings[static_cast<size_t>(side)], style);
  }
  const auto south = room.wall(0);
  add_door(draft, wall_frame(south[0], south[1]), room.openings[0][0], style.thickness_m, draft.pick(0.0, 0.5));
  // Something to see behind the door.
  const uint32_t outside = draft.material(Pattern::kPlaster, {0.4f, 0.4f, 0.4f});
  draft.begin("outside");
  draft.builder.add_box({door - 1.5, -1.8, 0.0}, {door + 2.4, -1.6, room.height_m}, outside);
  const auto east = room.wall(1);
  add_window(draft, wall_frame(east[0], east[1]), room.openings[1][0], style.thickness_m);

  add_structure(draft, room);
  FurnishOptions furnish;
  furnish.boards = 3;
  furnish_room(draft, room, furnish);
  const Vector2d size = room.high - room.low;
  for (const double x : {0.3, 0.7}) {
    add_ceiling_lamp(draft, {x * size.x(), draft.pick(0.2, 0.28) * size.y(), room.height_m - 0.06}, 0.0, 1.2, 0.3,
                     6.0f);
    add_ceiling_lamp(draft, {x * size.x(), draft.pick(0.75, 0.8) * size.y(), room.height_m - 0.06}, 0.0, 1.2, 0.3,
                     6.0f);
  }
  draft.scene.sky.sun_direction =
      Eigen::Vector3f(1.0f, static_cast<float>(draft.pick(-0.6, 0.6)), static_cast<float>(draft.pick(0.5, 0.9)))
          .normalized();
  draft.scene.sky.sun_irradiance = {9.0f, 8.5f, 7.5f};
  draft.scene.sky.ambient = Eigen::Vector3f::Constant(0.45f);
  draft.scene.sky.ambient_reach_m = 1.2f;
  draft.scene.way = way_around(draft, room);
  return draft.scene;
}

}  // namespace cpplus
