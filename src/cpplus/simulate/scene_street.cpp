#include <algorithm>
#include <cmath>

#include "cpplus/simulate/facade.h"
#include "cpplus/simulate/scene_builders.h"
#include "cpplus/simulate/traffic.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The street runs along x; y = 0 is its middle.
struct Plan {
  double length = 85.0;
  double road = 4.6;   // half width of the carriageway
  double front = 8.2;  // distance of the house fronts from the middle
  double kerb = 0.13;  // height
};

void add_ground(SceneDraft& draft, const Plan& plan) {
  const uint32_t asphalt = draft.material(Pattern::kAsphalt, {0.085f, 0.085f, 0.09f});
  const uint32_t paving = draft.material(Pattern::kTiles, draft.pick_muted(0.35f, 0.45f), {0.14f, 0.14f, 0.14f}, 0.5f);
  const uint32_t stone = draft.material(Pattern::kPlaster, {0.48f, 0.47f, 0.45f});
  const uint32_t white = draft.material(Pattern::kPlain, {0.7f, 0.7f, 0.68f});
  draft.edit_material(white).lidar_reflectance = 1.6f;
  const double x0 = -25.0;
  const double x1 = plan.length + 25.0;
  draft.begin("road");
  draft.builder.add_box({x0, -plan.road, -0.3}, {x1, plan.road, 0.0}, asphalt);
  for (const double side : {-1.0, 1.0}) {
    draft.begin("kerb");
    const double inner = side * plan.road;
    const double middle = side * (plan.road + 0.15);
    const double outer = side * (plan.front + 9.0);
    draft.builder.add_box({x0, std::min(inner, middle), -0.3}, {x1, std::max(inner, middle), plan.kerb}, stone);
    draft.begin("pavement");
    draft.builder.add_box({x0, std::min(middle, outer), -0.3}, {x1, std::max(middle, outer), plan.kerb}, paving);
  }
  draft.begin("markings");
  draft.builder.set_has_edges(false);
  constexpr double kPaint = 0.002;
  for (double x = 0.0; x < plan.length; x += 6.0) {
    draft.builder.add_quad({x, -0.06, kPaint}, {3.0, 0, 0}, {0, 0.12, 0}, white);
  }
  for (const double crossing : {0.3 * plan.length, 0.75 * plan.length}) {
    for (double y = -plan.road + 0.3; y < plan.road - 0.5; y += 1.0) {
      draft.builder.add_quad({crossing, y, kPaint}, {3.5, 0, 0}, {0, 0.5, 0}, white);
    }
  }
}

void add_houses(SceneDraft& draft, const Plan& plan) {
  for (const bool is_left : {true, false}) {
    double x = -20.0;
    while (x < plan.length + 20.0) {
      FacadeOptions house;
      house.width_m = draft.pick(8.5, 14.0);
      house.floors = 2 + static_cast<int>(draft.random.below(3));
      house.shop = draft.chance(0.6);
      const double back = draft.chance(0.25) ? draft.pick(0.3, 0.8) : 0.0;
      // Fronts face the road: on the left (y > 0) the frame is turned round.
      const Rigid3 frame = is_left ? placed_at({x + house.width_m, plan.front + back, plan.kerb}, M_PI)
                                   : placed_at({x, -plan.front - back, plan.kerb}, 0.0);
      add_house(draft, frame, house);
      x += house.width_m + (draft.chance(0.2) ? draft.pick(2.0, 4.0) : 0.02);
    }
  }
  // Houses across both ends close the view.
  FacadeOptions across;
  across.width_m = 2.0 * plan.front;
  across.floors = 4;
  add_house(draft, placed_at({-24.0, plan.front, 0.0}, -0.5 * M_PI), across);
  add_house(draft, placed_at({plan.length + 24.0, -plan.front, 0.0}, 0.5 * M_PI), across);
}

void add_roadside(SceneDraft& draft, const Plan& plan) {
  for (const double side : {-1.0, 1.0}) {
    const double y = side * (plan.road + 0.9);
    for (double x = draft.pick(0.0, 8.0); x < plan.length; x += draft.pick(9.0, 14.0)) {
      const double dice = draft.random.uniform();
      if (dice < 0.5) {
        add_tree(draft, {x, y, plan.kerb}, draft.pick(4.5, 6.5));
      } else if (dice < 0.8) {
        add_street_lamp(draft, {x, y, plan.kerb}, side > 0 ? M_PI : 0.0);
      } else {
        add_traffic_sign(draft, {x, y, plan.kerb}, side > 0 ? 0.5 * M_PI : -0.5 * M_PI);
      }
    }
    for (double x = draft.pick(3.0, 9.0); x < plan.length; x += draft.pick(5.5, 12.0)) {
      const bool on_crossing =
          std::abs(x - 0.3 * plan.length - 1.7) < 5.0 || std::abs(x - 0.75 * plan.length - 1.7) < 5.0;
      if (!on_crossing) add_parked_car(draft, placed_at({x, side * (plan.road - 1.1), 0.0}, side > 0 ? M_PI : 0.0));
    }
  }
}

void add_traffic(SceneDraft& draft, const Plan& plan) {
  for (int i = 0; i < 2; ++i) {
    add_driving_car(draft, {{-15.0, -1.5, 0.0}, {plan.length + 15.0, -1.5, 0.0}}, draft.pick(5.0, 8.0),
                    draft.pick(0.0, 60.0));
    add_driving_car(draft, {{plan.length + 15.0, 1.5, 0.0}, {-15.0, 1.5, 0.0}}, draft.pick(5.0, 8.0),
                    draft.pick(0.0, 60.0));
  }
  for (int i = 0; i < 5; ++i) {
    const double y = (draft.chance(0.5) ? 1.0 : -1.0) * draft.pick(plan.road + 1.6, plan.front - 0.9);
    add_walking_person(draft, {{0.0, y, plan.kerb}, {plan.length, y, plan.kerb}}, draft.pick(0.9, 1.5),
                       draft.pick(0.0, plan.length));
  }
}

}  // namespace

Scene build_street(uint64_t seed) {
  SceneDraft draft("street", seed);
  Plan plan;
  plan.length = draft.pick(75.0, 95.0);
  plan.road = draft.pick(4.3, 5.0);
  plan.front = plan.road + draft.pick(3.2, 4.2);
  add_ground(draft, plan);
  add_houses(draft, plan);
  add_roadside(draft, plan);
  add_traffic(draft, plan);
  const double side = draft.chance(0.5) ? 1.0 : -1.0;
  draft.scene.sky.sun_direction =
      Eigen::Vector3f(static_cast<float>(draft.pick(-0.5, 0.5)), static_cast<float>(0.6 * side),
                      static_cast<float>(draft.pick(0.7, 1.1)))
          .normalized();
  draft.scene.sky.sun_irradiance = {4.2f, 3.9f, 3.4f};
  draft.scene.sky.ambient = Eigen::Vector3f::Constant(0.28f);
  draft.scene.sky.ambient_reach_m = 6.0f;
  draft.scene.light_cell_m = 0.2f;
  // A cart on the pavement's edge of the road, looking ahead and to the fronts in turns.
  Way& way = draft.scene.way;
  constexpr int kPoints = 40;
  const double start = 0.12 * plan.length;
  for (int i = 0; i <= kPoints; ++i) {
    way.points.push_back({{start + 0.5 * plan.length * i / kPoints, -plan.road - 1.9 + 0.15 * std::sin(0.8 * i)},
                          0.1 + 0.55 * std::sin(0.45 * i)});
  }
  way.speed_mps = 1.4;
  way.lidar_height_m = 1.75;
  return draft.scene;
}

}  // namespace cpplus
