#include "cpplus/simulate/facade.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kReveal = 0.22;  // how deep windows are sunk

struct Palette {
  uint32_t wall;
  uint32_t trim;
  uint32_t glass;
  uint32_t frame;
};

Palette pick_palette(SceneDraft& draft) {
  Palette palette{};
  const double dice = draft.random.uniform();
  if (dice < 0.4) {
    palette.wall = draft.material(Pattern::kBrick,
                                  draft.pick_of({{0.42f, 0.16f, 0.10f}, {0.36f, 0.22f, 0.15f}, {0.50f, 0.38f, 0.26f}}),
                                  {0.42f, 0.40f, 0.37f}, 0.08f);
  } else if (dice < 0.85) {
    palette.wall = draft.material(
        Pattern::kPlaster,
        draft.pick_of({{0.62f, 0.58f, 0.48f}, {0.55f, 0.60f, 0.62f}, {0.66f, 0.50f, 0.38f}, {0.65f, 0.63f, 0.60f}}));
  } else {
    palette.wall = draft.material(Pattern::kConcrete, {0.45f, 0.44f, 0.42f}, {0.2f, 0.2f, 0.2f});
  }
  palette.trim = draft.material(Pattern::kPlaster, draft.pick_muted(0.45f, 0.65f));
  palette.glass = draft.material(Pattern::kPlain, Vector3f(0.05f, 0.06f, 0.08f));
  palette.frame = draft.material(Pattern::kPlain, draft.pick_muted(0.3f, 0.7f));
  return palette;
}

/// A pane with bars in the hole [x0, x1] x [z0, z1], and a sill below it.
void add_pane(SceneDraft& draft, const Palette& palette, double x0, double x1, double z0, double z1, bool sill) {
  constexpr double kBar = 0.06;
  const double back = -kReveal;
  const double front = -kReveal + 0.06;
  draft.builder.add_box({x0, back, z0}, {x0 + kBar, front, z1}, palette.frame);
  draft.builder.add_box({x1 - kBar, back, z0}, {x1, front, z1}, palette.frame);
  draft.builder.add_box({x0 + kBar, back, z1 - kBar}, {x1 - kBar, front, z1}, palette.frame);
  draft.builder.add_box({x0 + kBar, back, z0}, {x1 - kBar, front, z0 + kBar}, palette.frame);
  const double middle = 0.5 * (x0 + x1);
  draft.builder.add_box({middle - 0.025, back, z0 + kBar}, {middle + 0.025, front - 0.01, z1 - kBar}, palette.frame);
  if (sill) draft.builder.add_box({x0 - 0.06, -0.1, z0 - 0.07}, {x1 + 0.06, 0.07, z0}, palette.trim);
}

/// One storey of the front layer: solid bands below and above the row of holes, piers between.
void add_storey(SceneDraft& draft, const Palette& palette, double width, double z0, double z1, double hole_low,
                double hole_high, const std::vector<Eigen::Vector2d>& holes) {
  if (hole_low > z0) draft.builder.add_box({0.0, -kReveal, z0}, {width, 0.0, hole_low}, palette.wall);
  draft.builder.add_box({0.0, -kReveal, hole_high}, {width, 0.0, z1}, palette.wall);
  double x = 0.0;
  for (const Eigen::Vector2d& hole : holes) {
    draft.builder.add_box({x, -kReveal, hole_low}, {hole.x(), 0.0, hole_high}, palette.wall);
    x = hole.y();
  }
  draft.builder.add_box({x, -kReveal, hole_low}, {width, 0.0, hole_high}, palette.wall);
  for (const Eigen::Vector2d& hole : holes)
    add_pane(draft, palette, hole.x(), hole.y(), hole_low, hole_high, hole_low > z0);
}

std::vector<Eigen::Vector2d> even_holes(double width, double pitch, double hole) {
  std::vector<Eigen::Vector2d> holes;
  const int count = std::max(1, static_cast<int>(width / pitch));
  for (int i = 0; i < count; ++i) {
    const double center = width * (i + 0.5) / count;
    holes.emplace_back(center - 0.5 * hole, center + 0.5 * hole);
  }
  return holes;
}

void add_ground_floor(SceneDraft& draft, const Palette& palette, double width, double height, bool shop) {
  if (!shop) {
    add_storey(draft, palette, width, 0.0, height, 1.0, 2.4, even_holes(width - 0.0, 2.8, 1.2));
    // A door leaf with a canopy, set before the wall.
    const uint32_t leaf = draft.material(Pattern::kDoor, draft.pick_muted(0.1f, 0.35f), {0.1f, 0.08f, 0.06f});
    const double x = 0.06 * width;
    draft.builder.add_box({x, 0.0, 0.0}, {x + 0.95, 0.05, 2.1}, leaf);
    draft.builder.add_box({x - 0.3, 0.0, 2.25}, {x + 1.25, 0.8, 2.35}, palette.trim);
    return;
  }
  add_storey(draft, palette, width, 0.0, height, 0.45, 2.7, even_holes(width, 3.0, 2.2));
  const uint32_t sign = draft.material(Pattern::kSign, draft.pick_color(0.05f, 0.6f), {0.75f, 0.72f, 0.65f});
  draft.edit_material(sign).size_m = {static_cast<float>(0.7 * width), 0.55f};
  draft.builder.add_box({0.15 * width, 0.0, 2.85}, {0.85 * width, 0.1, 3.4}, palette.frame);
  draft.builder.add_quad({0.85 * width, 0.104, 2.85}, {-0.7 * width, 0.0, 0.0}, {0.0, 0.0, 0.55}, sign);
  if (draft.chance(0.6)) {
    const uint32_t cloth = draft.material(Pattern::kPlain, draft.pick_color(0.1f, 0.6f));
    for (double x = 0.15 * width; x < 0.8 * width - 2.0; x += 2.6) {
      const std::vector<Vector3d> top = {{x, 0.02, 2.82}, {x, 1.0, 2.4}, {x + 2.2, 1.0, 2.4}, {x + 2.2, 0.02, 2.82}};
      std::vector<Vector3d> bottom(top.rbegin(), top.rend());
      for (Vector3d& corner : bottom) corner.z() -= 0.02;
      draft.builder.add_polygon(top, cloth);
      draft.builder.add_polygon(bottom, cloth);
    }
  }
}

}  // namespace

void add_house(SceneDraft& draft, const Rigid3& frame, const FacadeOptions& options) {
  draft.begin("house", frame);
  const Palette palette = pick_palette(draft);
  const double ground = draft.pick(3.5, 3.9);
  const double storey = draft.pick(2.9, 3.3);
  const double top = ground + storey * (options.floors - 1) + 0.5;
  const double width = options.width_m;
  // The body behind the front layer; its front is what shows through the holes.
  draft.builder.add_box({0.0, -options.depth_m, 0.0}, {width, -kReveal - 0.01, top}, palette.wall);
  draft.builder.add_box({0.02, -kReveal - 0.01, 0.02}, {width - 0.02, -kReveal, top - 0.02}, palette.glass);
  add_ground_floor(draft, palette, width, ground, options.shop);
  const double pitch = draft.pick(2.2, 3.2);
  const double hole = draft.pick(1.0, 1.4);
  for (int i = 1; i < options.floors; ++i) {
    const double z = ground + storey * (i - 1);
    const double z1 = i + 1 == options.floors ? top : z + storey;
    add_storey(draft, palette, width, z, z1, z + 0.9, z + 2.3, even_holes(width, pitch, hole));
    draft.builder.add_box({0.0, 0.0, z - 0.1}, {width, 0.08, z + 0.08}, palette.trim);
    if (draft.chance(0.4)) {
      const double x = 0.5 * width - 1.0;
      draft.builder.add_box({x, 0.08, z + 0.1}, {x + 2.0, 0.9, z + 0.22}, palette.trim);
      for (double s = x + 0.03; s < x + 2.0; s += 0.24)
        draft.builder.add_box({s, 0.84, z + 0.22}, {s + 0.03, 0.87, z + 1.1}, palette.frame);
      draft.builder.add_box({x, 0.83, z + 1.1}, {x + 2.0, 0.88, z + 1.15}, palette.frame);
    }
  }
  draft.builder.add_box({-0.05, -options.depth_m, top}, {width + 0.05, 0.25, top + 0.2}, palette.trim);
}

void add_tree(SceneDraft& draft, const Vector3d& position, double height_m) {
  draft.begin("tree", placed_at(position, draft.pick(0.0, M_PI)));
  draft.builder.set_has_edges(false);
  const uint32_t bark = draft.material(Pattern::kPlaster, {0.16f, 0.11f, 0.07f});
  draft.edit_material(bark).contrast = 3.0f;
  draft.builder.add_cylinder({0, 0, 0}, {0, 0, 0.62 * height_m}, 0.14, 0.08, bark, 12);
  for (int i = 0; i < 5; ++i) {
    const double angle = 1.3 * i;
    draft.builder.add_cylinder(
        {0, 0, (0.42 + 0.04 * i) * height_m},
        {0.22 * height_m * std::cos(angle), 0.22 * height_m * std::sin(angle), (0.62 + 0.05 * i) * height_m}, 0.05,
        0.02, bark, 8);
  }
  std::vector<uint32_t> leaves;
  for (int i = 0; i < 5; ++i) {
    leaves.push_back(
        draft.material(Pattern::kPlain, Vector3f(0.11f, 0.26f, 0.06f) * static_cast<float>(draft.pick(0.6, 1.3))));
  }
  for (int i = 0; i < 420; ++i) {
    const Vector3d direction =
        Vector3d(draft.random.normal(), draft.random.normal(), draft.random.normal()).normalized();
    const Vector3d center = Vector3d(0, 0, 0.7 * height_m) + direction.cwiseProduct(Vector3d(0.27, 0.27, 0.24)) *
                                                                 height_m * std::cbrt(draft.pick(0.15, 1.0));
    const Vector3d u = Vector3d(draft.random.normal(), draft.random.normal(), draft.random.normal()).normalized();
    const double size = draft.pick(0.12, 0.24);
    const uint32_t leaf = leaves[draft.random.below(leaves.size())];
    draft.builder.add_quad(center, 1.4 * size * u, size * u.unitOrthogonal(), leaf);
    draft.builder.add_quad(center, size * u.unitOrthogonal(), 1.4 * size * u, leaf);  // the underside
  }
}

void add_street_lamp(SceneDraft& draft, const Vector3d& position, double yaw_rad) {
  draft.begin("street_lamp", placed_at(position, yaw_rad));
  draft.builder.set_has_edges(false);
  const uint32_t steel = draft.material(Pattern::kPlain, {0.22f, 0.23f, 0.24f});
  draft.builder.add_cylinder({0, 0, 0}, {0, 0, 0.9}, 0.11, 0.1, steel, 16);
  draft.builder.add_cylinder({0, 0, 0.9}, {0, 0, 5.4}, 0.07, 0.05, steel, 16);
  draft.builder.add_cylinder({0, 0, 5.35}, {0, 1.3, 5.6}, 0.035, 0.035, steel, 10);
  draft.builder.set_has_edges(true);
  draft.builder.add_box({-0.12, 1.1, 5.52}, {0.12, 1.7, 5.6}, steel);
}

void add_traffic_sign(SceneDraft& draft, const Vector3d& position, double yaw_rad) {
  draft.begin("traffic_sign", placed_at(position, yaw_rad));
  draft.builder.set_has_edges(false);
  const uint32_t steel = draft.material(Pattern::kPlain, {0.4f, 0.4f, 0.4f});
  draft.builder.add_cylinder({0, 0, 0}, {0, 0, 2.8}, 0.03, 0.03, steel, 12);
  draft.builder.set_has_edges(true);
  const uint32_t plate = draft.material(Pattern::kSign, draft.pick_color(0.05f, 0.6f), {0.8f, 0.8f, 0.8f});
  draft.edit_material(plate).size_m = {0.7f, 0.5f};
  draft.edit_material(plate).lidar_reflectance = 3.0f;
  draft.builder.add_box({-0.35, 0.03, 2.2}, {0.35, 0.05, 2.7}, steel);
  draft.builder.add_quad({0.35, 0.052, 2.2}, {-0.7, 0, 0}, {0, 0, 0.5}, plate);
}

}  // namespace cpplus
