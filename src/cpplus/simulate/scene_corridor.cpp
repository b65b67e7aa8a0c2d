#include <cmath>

#include "cpplus/simulate/room.h"
#include "cpplus/simulate/scene_builders.h"

namespace cpplus {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Nothing but floor, walls, skirting, ceiling and one long lamp: all edges but those of the far ends run along the
/// axis, so that the position along it cannot be told.
Scene build_corridor(uint64_t seed) {
  SceneDraft draft("corridor", seed);
  Room room;
  room.high = Vector2d(draft.pick(56.0, 70.0), draft.pick(1.9, 2.5));
  room.height_m = draft.pick(2.4, 2.8);
  const Vector2d margin(0.2, 0.2);
  const uint32_t floor = draft.material(Pattern::kPlain, draft.pick_muted(0.25f, 0.45f));
  const uint32_t ceiling = draft.material(Pattern::kPlaster, {0.66f, 0.66f, 0.64f});
  add_floor(draft, room.low - margin, room.high + margin, floor);
  add_ceiling(draft, room.low - margin, room.high + margin, room.height_m, ceiling);
  WallStyle style;
  style.height_m = room.height_m;
  style.thickness_m = 0.2;
  style.material = draft.material(Pattern::kPlaster, draft.pick_paint());
  style.trim = draft.material(Pattern::kPlain, draft.pick_muted(0.1f, 0.3f));
  for (int side = 0; side < 4; ++side) {
    const auto ends = room.wall(side);
    add_wall(draft, ends[0], ends[1], {}, style);
  }
  constexpr double kLamp = 4.0;
  const int lamps = static_cast<int>((room.high.x() - 0.5) / kLamp);
  for (int i = 0; i < lamps; ++i) {
    add_ceiling_lamp(draft, {0.25 + kLamp * (i + 0.5), room.center().y(), room.height_m - 0.06}, 0.0, kLamp, 0.12,
                     4.0f);
  }
  draft.scene.sky.ambient = Eigen::Vector3f::Constant(0.45f);
  const double start = 0.4 * room.high.x();
  constexpr int kPoints = 14;
  for (int i = 0; i <= kPoints; ++i) {
    const double sway = 0.15 * room.high.y() * std::sin(0.9 * i);
    draft.scene.way.points.push_back({{start + 9.0 * i / kPoints, room.center().y() + sway}, 0.12 * std::sin(1.3 * i)});
  }
  draft.scene.way.speed_mps = 0.9;
  return draft.scene;
}

}  // namespace cpplus
