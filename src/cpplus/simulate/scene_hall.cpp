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

/// A row of high windows and one or two doors in each wall.
void plan_openings(SceneDraft& draft, Room* room) {
  for (int side = 0; side < 4; ++side) {
    auto& openings = room->openings[static_cast<size_t>(side)];
    const double length = room->wall_length(side);
    const double door = draft.pick(0.2, 0.8) * length;
    const int count = static_cast<int>(length / 5.0);
    for (int i = 0; i < count; ++i) {
      const double center = length * (i + 0.5) / count;
      const bool at_door = std::abs(center - door) < 0.5 * length / count;
      if (at_door) {
        openings.push_back({center - 0.9, center + 0.9, 0.0, 2.3});
      } else if (draft.chance(0.8)) {
        openings.push_back({center - 1.1, center + 1.1, 0.5 * room->height_m, 0.8 * room->height_m});
      }
    }
  }
}

void add_walls(SceneDraft& draft, const Room& room) {
  WallStyle style;
  style.height_m = room.height_m;
  style.thickness_m = 0.3;
  style.skirting_m = 0.12;
  style.trim = draft.material(Pattern::kPlain, draft.pick_muted(0.1f, 0.25f));
  const uint32_t backdrop = draft.material(Pattern::kPlaster, {0.4f, 0.4f, 0.42f});
  for (int side = 0; side < 4; ++side) {
    style.material = draft.chance(0.5)
                         ? draft.material(Pattern::kBrick, {0.40f, 0.17f, 0.11f}, {0.45f, 0.43f, 0.40f}, 0.085f)
                         : draft.material(Pattern::kConcrete, {0.42f, 0.41f, 0.39f}, {0.15f, 0.15f, 0.15f});
    const auto ends = room.wall(side);
    const Rigid3 frame = wall_frame(ends[0], ends[1]);
    const auto& openings = room.openings[static_cast<size_t>(side)];
    add_wall(draft, ends[0], ends[1], openings, style);
    for (const WallOpening& opening : openings) {
      if (opening.low_m > 0.0) {
        add_window(draft, frame, opening, style.thickness_m);
        continue;
      }
      add_door(draft, frame, opening, style.thickness_m, std::numeric_limits<double>::quiet_NaN());
      draft.begin("outside", frame);
      draft.builder.add_box({opening.begin_m - 2.0, -3.2, -0.2}, {opening.end_m + 2.0, -3.0, 4.0}, backdrop);
      draft.builder.add_box({opening.begin_m - 2.0, -3.0, -0.2}, {opening.end_m + 2.0, -0.3, 0.0}, backdrop);
    }
  }
}

void add_columns_and_beams(SceneDraft& draft, const Room& room) {
  const uint32_t concrete = draft.material(Pattern::kConcrete, {0.45f, 0.44f, 0.42f}, {0.16f, 0.16f, 0.16f});
  const uint32_t steel = draft.material(Pattern::kPlain, draft.pick_muted(0.2f, 0.4f));
  const double length = room.high.x();
  const double width = room.high.y();
  const double half = draft.pick(0.2, 0.3);
  const int bays = static_cast<int>(std::round(length / 6.0));
  for (int i = 1; i < bays; ++i) {
    const double x = length * i / bays;
    for (const double y : {0.22 * width, 0.78 * width}) {
      draft.begin("column");
      draft.builder.add_box({x - half, y - half, 0.0}, {x + half, y + half, room.height_m}, concrete);
      draft.builder.add_box({x - half - 0.12, y - half - 0.12, 0.0}, {x + half + 0.12, y + half + 0.12, 0.25},
                            concrete);
    }
    draft.begin("beam");
    draft.builder.add_box({x - 0.15, 0.0, room.height_m - 0.6}, {x + 0.15, width, room.height_m}, steel);
  }
  draft.begin("duct");
  draft.builder.set_has_edges(false);
  draft.builder.add_cylinder({0.0, 0.35 * width, room.height_m - 1.0}, {length, 0.35 * width, room.height_m - 1.0},
                             0.25, 0.25, steel, 24);
}

/// A platform at the east end with steps up to it and a rail.
void add_stage(SceneDraft& draft, const Room& room) {
  const uint32_t planks = draft.material(Pattern::kPlanks, {0.42f, 0.27f, 0.15f}, {0.28f, 0.17f, 0.09f}, 0.15f);
  const uint32_t steel = draft.material(Pattern::kPlain, draft.pick_muted(0.1f, 0.3f));
  const double x = room.high.x() - draft.pick(4.0, 5.5);
  const double y0 = 0.3 * room.high.y();
  const double y1 = 0.7 * room.high.y();
  draft.begin("stage");
  draft.builder.add_box({x, y0, 0.0}, {room.high.x(), y1, 0.96}, planks);
  draft.begin("steps");
  for (int i = 0; i < 5; ++i) {
    draft.builder.add_box({x - 0.3 * (5 - i), y0 + 0.5, 0.0}, {x, y0 + 2.3, 0.16 * (i + 1)}, planks);
  }
  draft.begin("rail");
  for (double y = y0 + 2.5; y < y1; y += 1.0) {
    draft.builder.add_box({x + 0.05, y, 0.96}, {x + 0.1, y + 0.05, 1.9}, steel);
  }
  draft.builder.add_box({x + 0.04, y0 + 2.5, 1.9}, {x + 0.11, y1 - 0.3, 1.96}, steel);
}

void add_things(SceneDraft& draft, const Room& room) {
  const Vector2d size = room.high - room.low;
  for (int side = 0; side < 4; ++side) {
    const auto ends = room.wall(side);
    const Rigid3 frame = wall_frame(ends[0], ends[1]);
    for (double s = 2.0; s < room.wall_length(side) - 2.5; s += draft.pick(2.4, 3.6)) {
      bool blocked = false;
      for (const WallOpening& o : room.openings[static_cast<size_t>(side)]) {
        blocked = blocked || (o.low_m == 0.0 && s > o.begin_m - 1.6 && s < o.end_m + 1.6);
      }
      if (blocked || (side == 1 && std::abs(s - 0.5 * size.y()) < 0.25 * size.y())) continue;
      const Rigid3 place = frame * placed_at({s, 0.03, 0.0}, 0.0);
      switch (draft.random.below(6)) {
        case 0:
          add_bench(draft, place, 1.8);
          break;
        case 1:
          add_cabinet(draft, place, 1.4);
          break;
        case 2:
          add_crates(draft, place, 3);
          break;
        case 3:
          add_poster(draft, place, 1.2, 1.3, 1.75);
          break;
        case 4:
          add_checkerboard(draft, place, draft.pick(0.0, 0.2), draft.chance(0.5) ? 1.0 : 0.0);
          break;
        default:
          add_whiteboard(draft, place);
          break;
      }
    }
  }
  for (int i = 0; i < 4; ++i) {
    const Vector2d at(draft.pick(0.3, 0.65) * size.x(), draft.pick(0.42, 0.58) * size.y());
    const Rigid3 place = placed_at({at.x(), at.y(), 0.0}, draft.pick(0.0, M_PI));
    if (draft.chance(0.5)) {
      add_table(draft, place, 1.8, 0.8);
    } else {
      add_crates(draft, place, 2 + static_cast<int>(draft.random.below(3)));
    }
  }
}

}  // namespace

Scene build_hall(uint64_t seed) {
  SceneDraft draft("hall", seed);
  Room room;
  room.high = Vector2d(draft.pick(26.0, 34.0), draft.pick(15.0, 20.0));
  room.height_m = draft.pick(6.5, 8.5);
  plan_openings(draft, &room);
  const Vector2d margin(0.3, 0.3);
  const uint32_t floor =
      draft.chance(0.5) ? draft.material(Pattern::kTiles, draft.pick_muted(0.3f, 0.5f), {0.12f, 0.12f, 0.12f}, 0.8f)
                        : draft.material(Pattern::kConcrete, {0.38f, 0.37f, 0.36f}, {0.2f, 0.2f, 0.2f});
  add_floor(draft, room.low - margin, room.high + margin, floor);
  add_ceiling(draft, room.low - margin, room.high + margin, room.height_m,
              draft.material(Pattern::kPlanks, {0.5f, 0.48f, 0.45f}, {0.4f, 0.38f, 0.35f}, 0.3f));
  add_walls(draft, room);
  add_columns_and_beams(draft, room);
  add_stage(draft, room);
  add_things(draft, room);
  const Vector2d size = room.high;
  for (int i = 0; i < 4; ++i) {
    for (const double y : {0.3, 0.7}) {
      add_ceiling_lamp(draft, {size.x() * (i + 0.5) / 4, y * size.y(), room.height_m - 1.2}, 0.0, 1.8, 0.6, 25.0f);
    }
  }
  constexpr int kPoints = 30;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = -2.4 + 1.5 * M_PI * i / kPoints;
    const Vector2d offset(0.30 * size.x() * std::cos(angle), 0.17 * size.y() * std::sin(angle));
    const Vector2d ahead(-0.30 * size.x() * std::sin(angle), 0.17 * size.y() * std::cos(angle));
    draft.scene.way.points.push_back({0.5 * size - Vector2d(0.08 * size.x(), 0.0) + 1.05 * offset,
                                      std::atan2(ahead.y(), ahead.x()) + 0.5 * std::sin(2.3 * angle)});
  }
  draft.scene.way.speed_mps = 1.0;
  for (int i = 0; i < 4; ++i) {
    const double y = draft.pick(0.3, 0.7) * size.y();
    add_walking_person(draft, {{0.15 * size.x(), y, 0.0}, {0.75 * size.x(), draft.pick(0.3, 0.7) * size.y(), 0.0}},
                       draft.pick(0.8, 1.4), draft.pick(0.0, 25.0));
  }
  draft.scene.sky.sun_direction =
      Eigen::Vector3f(static_cast<float>(draft.pick(-0.8, 0.8)), -1.0f, static_cast<float>(draft.pick(0.5, 1.0)))
          .normalized();
  draft.scene.sky.sun_irradiance = {9.0f, 8.5f, 7.5f};
  draft.scene.sky.ambient = Eigen::Vector3f::Constant(0.4f);
  draft.scene.sky.ambient_reach_m = 2.5f;
  draft.scene.light_cell_m = 0.12f;
  return draft.scene;
}

}  // namespace cpplus
