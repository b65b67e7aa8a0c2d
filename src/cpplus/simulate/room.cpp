#include "cpplus/simulate/room.h"

#include <algorithm>
#include <cmath>

#include "cpplus/simulate/furniture.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Slot {
  int side;
  double begin;
  double end;
};

/// Stretches of wall where furniture may stand: away from corners and doors; under windows only low things may.
std::vector<Slot> furniture_slots(const Room& room) {
  constexpr double kCorner = 0.65;
  constexpr double kDoorClear = 0.35;
  std::vector<Slot> slots;
  for (int side = 0; side < 4; ++side) {
    double begin = kCorner;
    for (const WallOpening& opening : room.openings[static_cast<size_t>(side)]) {
      if (opening.begin_m - kDoorClear > begin) slots.push_back({side, begin, opening.begin_m - kDoorClear});
      begin = std::max(begin, opening.end_m + kDoorClear + (opening.low_m < 0.1 ? 0.4 : 0.0));
    }
    if (room.wall_length(side) - kCorner > begin) slots.push_back({side, begin, room.wall_length(side) - kCorner});
  }
  return slots;
}

Rigid3 at_wall(const Room& room, int side, double along) {
  const auto ends = room.wall(side);
  return wall_frame(ends[0], ends[1]) * placed_at({along, 0.02, 0.0}, 0.0);
}

/// One thing against the wall, no wider than `room_left`; returns the width taken.
double add_item(SceneDraft& draft, const Room& room, const Slot& slot, double begin, int* boards_left) {
  const double space = slot.end - begin;
  const auto place = [&](double width) { return at_wall(room, slot.side, begin + 0.5 * width); };
  if (*boards_left > 0 && space > 1.0 && draft.chance(0.5)) {
    --*boards_left;
    const bool hung = draft.chance(0.4);
    add_checkerboard(draft, place(1.0), hung ? 0.0 : draft.pick(0.05, 0.25), hung ? draft.pick(1.0, 1.3) : 0.0);
    return 1.0;
  }
  const int kind = static_cast<int>(draft.random.below(7));
  const double width = std::min(space, draft.pick(0.8, 1.25));
  if (kind <= 1 && width > 0.6) {
    add_bookshelf(draft, place(width), width);
  } else if (kind == 2 && width > 0.6) {
    add_cabinet(draft, place(width), width);
  } else if (kind == 3 && space > 1.3) {
    add_desk(draft, place(1.3), 1.3);
    add_chair(draft, place(1.3) * placed_at({-0.15, 0.85, 0.0}, draft.pick(2.7, 3.6)));
    if (draft.chance(0.7)) add_poster(draft, place(1.3), 1.45, 0.6, 0.8);
    return 1.3;
  } else if (kind == 4) {
    add_crates(draft, place(0.8), 2 + static_cast<int>(draft.random.below(3)));
    return 0.8;
  } else if (kind == 5 && space > 1.9) {
    add_whiteboard(draft, place(1.9));
    return 1.9;
  } else {
    const double poster_width = draft.pick(0.5, 0.8);
    add_poster(draft, place(0.9), draft.pick(0.9, 1.2), poster_width, 1.35 * poster_width);
    return 0.9;
  }
  return width;
}

}  // namespace

std::array<Vector2d, 2> Room::wall(int side) const {
  const std::array<Vector2d, 4> corners = {low, Vector2d(high.x(), low.y()), high, Vector2d(low.x(), high.y())};
  return {corners[static_cast<size_t>(side)], corners[static_cast<size_t>((side + 1) % 4)]};
}

void add_floor(SceneDraft& draft, const Vector2d& low, const Vector2d& high, uint32_t material) {
  draft.begin("floor");
  draft.builder.add_box({low.x(), low.y(), -0.2}, {high.x(), high.y(), 0.0}, material);
}

void add_ceiling(SceneDraft& draft, const Vector2d& low, const Vector2d& high, double height_m, uint32_t material) {
  draft.begin("ceiling");
  draft.builder.add_box({low.x(), low.y(), height_m}, {high.x(), high.y(), height_m + 0.2}, material);
}

void furnish_room(SceneDraft& draft, const Room& room, const FurnishOptions& options) {
  const Vector2d center = room.center();
  if (options.table) {
    const double yaw = room.wall_length(0) > room.wall_length(1) ? 0.0 : 0.5 * M_PI;
    const Rigid3 middle = placed_at({center.x(), center.y(), 0.0}, yaw + draft.pick(-0.15, 0.15));
    const double length = draft.pick(1.3, 1.7);
    if (options.rug) add_rug(draft, middle, length + 1.0, 1.7);
    add_table(draft, middle * placed_at({0, 0, options.rug ? 0.0075 : 0.0}, 0.0), length, 0.8);
    for (const double side : {-1.0, 1.0}) {
      const Rigid3 seat =
          placed_at({draft.pick(-0.4, 0.4), side * draft.pick(0.5, 0.75), 0.0075}, side > 0 ? M_PI : 0.0);
      if (draft.chance(0.8)) add_chair(draft, middle * seat * placed_at({0, 0, 0}, draft.pick(-0.4, 0.4)));
    }
  }
  int boards_left = options.boards;
  std::vector<Slot> slots = furniture_slots(room);
  for (const Slot& slot : slots) {
    double along = slot.begin + draft.pick(0.0, 0.2);
    while (slot.end - along > 0.8) {
      along += draft.chance(options.density) ? add_item(draft, room, slot, along, &boards_left) : 0.8;
      along += draft.pick(0.05, 0.4);
    }
  }
  // Boards that found no place at a wall stand before the corners, as a calibration target would.
  const double inset = 0.75;
  for (int corner = 0; boards_left > 0 && corner < 4; ++corner, --boards_left) {
    const auto ends = room.wall(corner);
    const Vector2d into = (center - ends[0]).normalized();
    const Vector2d position = ends[0] + 1.1 * inset * into;
    add_checkerboard(draft, placed_at({position.x(), position.y(), 0.0}, std::atan2(into.y(), into.x()) - 0.5 * M_PI),
                     draft.pick(0.0, 0.2), 0.0);
  }
  for (int i = 0; i < options.plants; ++i) {
    const auto ends = room.wall(static_cast<int>(draft.random.below(4)));
    const Vector2d position = ends[0] + 0.55 * (center - ends[0]).normalized();
    add_plant(draft, placed_at({position.x(), position.y(), 0.0}, 0.0));
  }
}

void add_structure(SceneDraft& draft, const Room& room) {
  const uint32_t concrete = draft.material(Pattern::kConcrete, {0.42f, 0.41f, 0.39f}, {0.15f, 0.15f, 0.15f});
  const double z = room.height_m;
  const double column = draft.pick(0.25, 0.4);
  draft.begin("column");
  for (int corner = 0; corner < 4; ++corner) {
    if (!draft.chance(0.5)) continue;
    const Vector2d at = room.wall(corner)[0];
    const Vector2d low(at.x() == room.low.x() ? at.x() : at.x() - column,
                       at.y() == room.low.y() ? at.y() : at.y() - column);
    draft.builder.add_box({low.x(), low.y(), 0.0}, {low.x() + column, low.y() + column, z}, concrete);
  }
  draft.begin("beam");
  const double y = draft.pick(0.3, 0.7) * (room.high.y() - room.low.y()) + room.low.y();
  draft.builder.add_box({room.low.x(), y - 0.12, z - 0.28}, {room.high.x(), y + 0.12, z}, concrete);
  draft.begin("pipe");
  draft.builder.set_has_edges(false);
  const uint32_t pipe = draft.material(Pattern::kPlain, draft.pick_color(0.3f, 0.6f));
  const double py = room.low.y() + draft.pick(0.2, 0.35);
  draft.builder.add_cylinder({room.low.x(), py, z - 0.22}, {room.high.x(), py, z - 0.22}, 0.06, 0.06, pipe, 16);
}

}  // namespace cpplus
