#include "cpplus/simulate/scene_draft.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

uint64_t name_hash(const std::string& name) {
  uint64_t hash = 7;
  for (const char letter : name) hash = hash_seed(hash, static_cast<unsigned char>(letter));
  return hash;
}

/// The parts of [0, length] outside the openings that reach below `height`.
std::vector<Vector2d> free_stretches(double length, const std::vector<WallOpening>& openings, double height) {
  std::vector<Vector2d> stretches;
  double begin = 0.0;
  for (const WallOpening& opening : openings) {
    if (opening.low_m >= height) continue;
    if (opening.begin_m > begin) stretches.emplace_back(begin, opening.begin_m);
    begin = std::max(begin, opening.end_m);
  }
  if (begin < length) stretches.emplace_back(begin, length);
  return stretches;
}

}  // namespace

SceneDraft::SceneDraft(const std::string& name, uint64_t seed)
    : random(hash_seed(seed, name_hash(name))), builder(&scene.mesh) {
  scene.name = name;
  scene.sky.seed = static_cast<uint32_t>(random.next());
}

uint32_t SceneDraft::material(Pattern pattern, const Vector3f& color, const Vector3f& color2, float scale_m) {
  Material material;
  material.pattern = pattern;
  material.color = color;
  material.color2 = color2;
  material.scale_m = scale_m;
  material.seed = static_cast<uint32_t>(random.next());
  scene.materials.push_back(material);
  return static_cast<uint32_t>(scene.materials.size() - 1);
}

void SceneDraft::begin(const std::string& object_name, const Rigid3& frame) {
  scene.objects.push_back(object_name);
  builder.set_object(static_cast<uint32_t>(scene.objects.size() - 1));
  builder.set_frame(frame);
  builder.set_has_edges(true);
}

Vector3f SceneDraft::pick_color(float low, float high) {
  Vector3f color;
  for (int k = 0; k < 3; ++k) color[k] = static_cast<float>(random.uniform(low, high));
  return color;
}

Vector3f SceneDraft::pick_muted(float low, float high) {
  const Vector3f color = pick_color(low, high);
  return color + 0.7f * (Vector3f::Constant(color.mean()) - color);
}

Vector3f SceneDraft::pick_paint() {
  return pick_of({{0.62f, 0.58f, 0.50f},
                  {0.55f, 0.60f, 0.58f},
                  {0.66f, 0.64f, 0.62f},
                  {0.50f, 0.38f, 0.14f},
                  {0.40f, 0.50f, 0.60f},
                  {0.58f, 0.46f, 0.38f},
                  {0.45f, 0.55f, 0.40f}});
}

Vector3f SceneDraft::pick_of(std::initializer_list<Vector3f> colors) {
  return *(colors.begin() + random.below(colors.size()));
}

Rigid3 wall_frame(const Vector2d& a, const Vector2d& b) {
  return placed_at(Vector3d(a.x(), a.y(), 0.0), std::atan2(b.y() - a.y(), b.x() - a.x()));
}

void add_wall(SceneDraft& draft, const Vector2d& a, const Vector2d& b, const std::vector<WallOpening>& openings,
              const WallStyle& style) {
  const double length = (b - a).norm();
  const double back = -style.thickness_m;
  draft.begin("wall", wall_frame(a, b));
  for (const Vector2d& s : free_stretches(length, openings, 1e9)) {
    draft.builder.add_box({s.x(), back, 0.0}, {s.y(), 0.0, style.height_m}, style.material);
  }
  for (const WallOpening& o : openings) {
    if (o.low_m > 0.0) draft.builder.add_box({o.begin_m, back, 0.0}, {o.end_m, 0.0, o.low_m}, style.material);
    if (o.high_m < style.height_m) {
      draft.builder.add_box({o.begin_m, back, o.high_m}, {o.end_m, 0.0, style.height_m}, style.material);
    }
  }
  if (style.skirting_m <= 0.0) return;
  draft.begin("skirting", wall_frame(a, b));
  constexpr double kDepth = 0.015;
  constexpr double kDoorFrame = 0.07;
  for (Vector2d s : free_stretches(length, openings, style.skirting_m)) {
    if (s.x() > 0.0) s.x() += kDoorFrame;
    if (s.y() < length) s.y() -= kDoorFrame;
    if (s.y() - s.x() < 0.05) continue;
    draft.builder.add_box({s.x(), 0.0, 0.0}, {s.y(), kDepth, style.skirting_m}, style.trim);
    if (style.skirting_right) {
      draft.builder.add_box({s.x(), back - kDepth, 0.0}, {s.y(), back, style.skirting_m}, style.trim);
    }
  }
}

void add_door(SceneDraft& draft, const Rigid3& wall, const WallOpening& o, double thickness_m, double open_rad) {
  const uint32_t frame = draft.material(Pattern::kPlain, draft.pick_muted(0.25f, 0.6f));
  draft.begin("door_frame", wall);
  constexpr double kWidth = 0.07;
  constexpr double kProud = 0.02;
  const double back = -thickness_m - kProud;
  draft.builder.add_box({o.begin_m - kWidth, back, 0.0}, {o.begin_m + 0.01, kProud, o.high_m}, frame);
  draft.builder.add_box({o.end_m - 0.01, back, 0.0}, {o.end_m + kWidth, kProud, o.high_m}, frame);
  draft.builder.add_box({o.begin_m - kWidth, back, o.high_m - 0.01}, {o.end_m + kWidth, kProud, o.high_m + kWidth},
                        frame);
  if (std::isnan(open_rad)) return;
  const Vector3f color = draft.pick_of({{0.35f, 0.20f, 0.10f}, {0.30f, 0.42f, 0.52f}, {0.55f, 0.53f, 0.50f}});
  const uint32_t leaf = draft.material(Pattern::kDoor, color, 0.7f * color);
  draft.begin("door", wall * placed_at({o.begin_m + 0.02, 0.0, 0.0}, open_rad));
  const double width = o.end_m - o.begin_m - 0.04;
  draft.builder.add_box({0.0, -0.045, 0.01}, {width, 0.0, o.high_m - 0.02}, leaf);
  const uint32_t metal = draft.material(Pattern::kPlain, {0.6f, 0.6f, 0.6f});
  draft.builder.add_box({width - 0.15, -0.10, 1.02}, {width - 0.05, 0.055, 1.04}, metal);
}

void add_window(SceneDraft& draft, const Rigid3& wall, const WallOpening& o, double thickness_m) {
  const uint32_t bars = draft.material(Pattern::kPlain, draft.pick_muted(0.5f, 0.7f));
  draft.begin("window", wall);
  constexpr double kBar = 0.06;
  const double y0 = -0.75 * thickness_m;
  const double y1 = -0.35 * thickness_m;
  const double middle = 0.5 * (o.begin_m + o.end_m);
  draft.builder.add_box({o.begin_m, y0, o.low_m}, {o.begin_m + kBar, y1, o.high_m}, bars);
  draft.builder.add_box({o.end_m - kBar, y0, o.low_m}, {o.end_m, y1, o.high_m}, bars);
  draft.builder.add_box({o.begin_m + kBar, y0, o.low_m}, {o.end_m - kBar, y1, o.low_m + kBar}, bars);
  draft.builder.add_box({o.begin_m + kBar, y0, o.high_m - kBar}, {o.end_m - kBar, y1, o.high_m}, bars);
  draft.builder.add_box({middle - 0.03, y0, o.low_m + kBar}, {middle + 0.03, y1, o.high_m - kBar}, bars);
  draft.builder.add_box({o.begin_m - 0.05, -0.3 * thickness_m, o.low_m - 0.03}, {o.end_m + 0.05, 0.10, o.low_m + 0.005},
                        bars);
}

void add_ceiling_lamp(SceneDraft& draft, const Vector3d& position, double yaw_rad, double length_m, double width_m,
                      float radiance) {
  const uint32_t housing = draft.material(Pattern::kPlain, {0.6f, 0.6f, 0.6f});
  const uint32_t shine = draft.material(Pattern::kPlain, {1.0f, 0.97f, 0.9f});
  draft.edit_material(shine).emission = radiance;
  draft.begin("lamp", placed_at(position, yaw_rad));
  const double x = 0.5 * length_m;
  const double y = 0.5 * width_m;
  draft.builder.add_box({-x - 0.02, -y - 0.02, 0.0}, {x + 0.02, y + 0.02, 0.06}, housing);
  draft.builder.add_quad({-x, y, -0.002}, {2.0 * x, 0.0, 0.0}, {0.0, -2.0 * y, 0.0}, shine);
  AreaLight light;
  const Rigid3 frame = placed_at(position, yaw_rad);
  light.center = (frame * Vector3d(0.0, 0.0, -0.008)).cast<float>();
  light.half_u = (frame.rotation * Vector3d(x, 0.0, 0.0)).cast<float>();
  light.half_v = (frame.rotation * Vector3d(0.0, -y, 0.0)).cast<float>();
  light.radiance = radiance * Vector3f(1.0f, 0.97f, 0.9f);
  draft.scene.lights.push_back(light);
}

}  // namespace cpplus
