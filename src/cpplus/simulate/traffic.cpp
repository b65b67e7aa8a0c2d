#include "cpplus/simulate/traffic.h"

#include <cmath>

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct CarPaint {
  uint32_t body;
  uint32_t glass;
  uint32_t tyre;
  uint32_t lamp;
};

CarPaint pick_paint(SceneDraft& draft) {
  const Eigen::Vector3f color = draft.pick_of({{0.55f, 0.55f, 0.56f},
                                               {0.08f, 0.12f, 0.30f},
                                               {0.45f, 0.05f, 0.04f},
                                               {0.06f, 0.06f, 0.07f},
                                               {0.7f, 0.7f, 0.68f},
                                               {0.1f, 0.25f, 0.18f}});
  CarPaint paint{};
  paint.body = draft.material(Pattern::kPlain, color);
  paint.glass = draft.material(Pattern::kPlain, {0.03f, 0.04f, 0.05f});
  paint.tyre = draft.material(Pattern::kPlain, {0.03f, 0.03f, 0.03f});
  paint.lamp = draft.material(Pattern::kPlain, {0.7f, 0.65f, 0.55f});
  draft.edit_material(paint.body).contrast = 0.3f;
  return paint;
}

void build_car(MeshBuilder* builder, const CarPaint& paint) {
  constexpr double kHalfWidth = 0.88;
  // Lower body, with slanted bonnet and boot, and the cabin above it.
  builder->add_prism({{-2.1, 0.28}, {2.1, 0.28}, {2.15, 0.6}, {1.2, 0.86}, {-1.75, 0.9}, {-2.15, 0.8}}, -kHalfWidth,
                     kHalfWidth, paint.body);
  builder->add_prism({{-1.75, 0.86}, {1.0, 0.84}, {0.35, 1.38}, {-1.1, 1.4}}, -0.76, 0.76, paint.glass);
  builder->add_prism({{-1.15, 1.385}, {0.4, 1.37}, {0.3, 1.43}, {-1.05, 1.45}}, -0.74, 0.74, paint.body);
  for (const double side : {-1.0, 1.0}) {
    builder->add_box({-0.42, side * 0.765 - 0.01, 0.86}, {-0.34, side * 0.765 + 0.01, 1.4}, paint.body);
    builder->add_box({2.05, side * 0.62 - 0.16, 0.56}, {2.17, side * 0.62 + 0.16, 0.68}, paint.lamp);
  }
  builder->set_has_edges(false);
  for (const double x : {-1.3, 1.35}) {
    for (const double side : {-1.0, 1.0}) {
      builder->add_cylinder({x, side * 0.7, 0.32}, {x, side * 0.91, 0.32}, 0.32, 0.32, paint.tyre, 20);
      builder->add_cylinder({x, side * 0.91, 0.32}, {x, side * 0.92, 0.32}, 0.2, 0.18, paint.lamp, 16);
    }
  }
  builder->set_has_edges(true);
}

}  // namespace

void add_walking_person(SceneDraft& draft, const std::vector<Vector3d>& path, double speed_mps, double start_m) {
  const uint32_t coat = draft.material(Pattern::kPlain, draft.pick_color(0.04f, 0.5f));
  const uint32_t trousers = draft.material(Pattern::kPlain, draft.pick_color(0.03f, 0.2f));
  const uint32_t skin = draft.material(Pattern::kPlain, {0.45f, 0.30f, 0.22f});
  const uint32_t hair = draft.material(Pattern::kPlain, draft.pick_color(0.02f, 0.15f));
  MovingBody part;
  part.path = path;
  part.speed_mps = speed_mps;
  part.start_m = start_m;

  MovingBody trunk = part;
  MeshBuilder builder(&trunk.mesh);
  builder.add_cylinder({0, 0, 0.82}, {0, 0, 1.12}, 0.16, 0.15, trousers, 14);
  builder.add_cylinder({0, 0, 1.0}, {0, 0, 1.42}, 0.15, 0.2, coat, 14);
  builder.add_sphere({0, 0, 1.42}, {0.17, 0.21, 0.1}, coat);
  builder.add_sphere({0.01, 0, 1.62}, {0.1, 0.085, 0.13}, skin);
  builder.add_sphere({-0.02, 0, 1.66}, {0.105, 0.092, 0.11}, hair);
  draft.scene.bodies.push_back(trunk);

  const double step_hz = 0.5 * 1.35 * speed_mps;  // two steps a swing, 0.74 m each
  for (const double side : {-1.0, 1.0}) {
    for (const bool is_leg : {true, false}) {
      MovingBody limb = part;
      MeshBuilder limb_builder(&limb.mesh);
      if (is_leg) {
        limb_builder.add_cylinder({0, side * 0.09, 0.03}, {0, side * 0.09, 0.88}, 0.06, 0.085, trousers, 10);
        limb_builder.add_box({-0.08, side * 0.09 - 0.045, 0.0}, {0.18, side * 0.09 + 0.045, 0.07}, hair);
        limb.pivot = {0, 0, 0.88};
      } else {
        limb_builder.add_cylinder({0, side * 0.25, 0.82}, {0, side * 0.22, 1.42}, 0.04, 0.055, coat, 10);
        limb_builder.add_sphere({0, side * 0.25, 0.78}, {0.045, 0.04, 0.08}, skin);
        limb.pivot = {0, 0, 1.42};
      }
      limb.swing_rad = is_leg ? 0.38 : 0.3;
      limb.swing_hz = step_hz;
      limb.swing_phase_rad = (side > 0) == is_leg ? 0.0 : M_PI;
      draft.scene.bodies.push_back(limb);
    }
  }
}

void add_driving_car(SceneDraft& draft, const std::vector<Vector3d>& path, double speed_mps, double start_m) {
  MovingBody car;
  car.path = path;
  car.speed_mps = speed_mps;
  car.start_m = start_m;
  MeshBuilder builder(&car.mesh);
  build_car(&builder, pick_paint(draft));
  draft.scene.bodies.push_back(car);
}

void add_parked_car(SceneDraft& draft, const Rigid3& frame) {
  draft.begin("parked_car", frame);
  build_car(&draft.builder, pick_paint(draft));
}

}  // namespace cpplus
