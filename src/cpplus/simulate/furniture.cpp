#include "cpplus/simulate/furniture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

uint32_t wood_material(SceneDraft& draft) {
  const Vector3f color =
      draft.pick_of({{0.50f, 0.33f, 0.18f}, {0.36f, 0.21f, 0.11f}, {0.60f, 0.45f, 0.28f}, {0.62f, 0.61f, 0.58f}});
  return draft.material(Pattern::kWood, color, 0.65f * color);
}

uint32_t cardboard_material(SceneDraft& draft) {
  return draft.material(Pattern::kCardboard, Vector3f(0.45f, 0.30f, 0.17f) * static_cast<float>(draft.pick(0.8, 1.2)));
}

/// Books from x to x_end on a board at height z, some shelves with boxes instead.
void fill_shelf(SceneDraft& draft, double x, double x_end, double z, double clear_height, double depth) {
  while (x < x_end - 0.03) {
    if (draft.chance(0.06)) {
      x += draft.pick(0.05, 0.2);
      continue;
    }
    if (draft.chance(0.08) && x + 0.3 < x_end) {
      const double width = draft.pick(0.2, 0.3);
      draft.builder.add_box({x, 0.05, z}, {x + width, depth - 0.03, z + draft.pick(0.12, clear_height - 0.04)},
                            cardboard_material(draft));
      x += width + 0.02;
      continue;
    }
    const double width = std::min(draft.pick(0.02, 0.06), x_end - x);
    const double height = std::min(draft.pick(0.19, 0.31), clear_height - 0.02);
    const uint32_t cover = draft.material(Pattern::kPlain, draft.pick_color(0.05f, 0.7f));
    draft.builder.add_box({x, 0.06, z}, {x + width, 0.06 + draft.pick(0.14, 0.2), z + height}, cover);
    x += width + 0.001;
  }
}

void add_legs(SceneDraft& draft, double half_x, double half_y, double height, double thickness, uint32_t material) {
  for (const double x : {-half_x, half_x - thickness}) {
    for (const double y : {-half_y, half_y - thickness}) {
      draft.builder.add_box({x, y, 0.0}, {x + thickness, y + thickness, height}, material);
    }
  }
}

/// A plate whose front (material `front`, at y = thickness) faces +y; u and v of the front start at its lower left
/// corner as seen from the front.
void add_plate(SceneDraft& draft, double width, double height, double thickness, uint32_t front, uint32_t body) {
  const double x = 0.5 * width;
  const Vector3d right(width, 0.0, 0.0);
  const Vector3d deep(0.0, thickness, 0.0);
  const Vector3d up(0.0, 0.0, height);
  draft.builder.add_quad({x, thickness, 0.0}, -right, up, front);
  draft.builder.add_quad({-x, 0.0, 0.0}, right, up, body);
  draft.builder.add_quad({-x, 0.0, 0.0}, up, deep, body);
  draft.builder.add_quad({x, 0.0, 0.0}, deep, up, body);
  draft.builder.add_quad({-x, 0.0, 0.0}, deep, right, body);
  draft.builder.add_quad({-x, 0.0, height}, right, deep, body);
}

Rigid3 tilted_back(const Rigid3& frame, const Vector3d& offset, double tilt_rad) {
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(tilt_rad, Vector3d::UnitX()));
  return frame * Rigid3(tilt, offset);
}

}  // namespace

void add_bookshelf(SceneDraft& draft, const Rigid3& frame, double width_m) {
  draft.begin("bookshelf", frame);
  const uint32_t wood = wood_material(draft);
  const double depth = draft.pick(0.28, 0.36);
  const int shelves = 4 + static_cast<int>(draft.random.below(3));
  const double pitch = draft.pick(0.34, 0.39);
  const double height = pitch * shelves + 0.06;
  const double x = 0.5 * width_m;
  constexpr double kBoard = 0.024;
  draft.builder.add_box({-x, 0.01, 0.0}, {-x + kBoard, depth, height}, wood);
  draft.builder.add_box({x - kBoard, 0.01, 0.0}, {x, depth, height}, wood);
  draft.builder.add_box({-x, 0.0, 0.0}, {x, 0.01, height}, wood);
  for (int i = 0; i <= shelves; ++i) {
    const double z = i == shelves ? height - kBoard : 0.05 + pitch * i;
    draft.builder.add_box({-x + kBoard, 0.01, z}, {x - kBoard, depth - 0.004, z + kBoard}, wood);
    if (i < shelves && draft.chance(0.85)) {
      fill_shelf(draft, -x + kBoard + 0.01, x - kBoard - draft.pick(0.0, 0.3), z + kBoard, pitch - kBoard, depth);
    }
  }
}

void add_cabinet(SceneDraft& draft, const Rigid3& frame, double width_m) {
  draft.begin("cabinet", frame);
  const uint32_t body =
      draft.chance(0.5) ? wood_material(draft) : draft.material(Pattern::kPlain, draft.pick_muted(0.3f, 0.6f));
  const double x = 0.5 * width_m;
  const double depth = draft.pick(0.4, 0.55);
  const double height = draft.pick(0.8, 1.9);
  const uint32_t handle = draft.material(Pattern::kPlain, {0.15f, 0.15f, 0.15f});
  draft.builder.add_box({-x, 0.0, 0.05}, {x, depth, height}, body);
  draft.builder.add_box({-x + 0.03, 0.03, 0.0}, {x - 0.03, depth - 0.05, 0.05}, handle);
  for (const double side : {-1.0, 1.0}) {
    const double inner = side * 0.006;
    draft.builder.add_box({std::min(inner, side * (x - 0.01)), depth, 0.06},
                          {std::max(inner, side * (x - 0.01)), depth + 0.018, height - 0.01}, body);
    draft.builder.add_box({side * 0.05 - 0.008, depth + 0.018, 0.5 * height - 0.08},
                          {side * 0.05 + 0.008, depth + 0.045, 0.5 * height + 0.08}, handle);
  }
  if (draft.chance(0.6)) {
    draft.builder.add_box({-0.3 * x, 0.1, height}, {0.5 * x, depth - 0.08, height + draft.pick(0.15, 0.3)},
                          cardboard_material(draft));
  }
}

void add_desk(SceneDraft& draft, const Rigid3& frame, double width_m) {
  draft.begin("desk", frame);
  const uint32_t top = wood_material(draft);
  const uint32_t steel = draft.material(Pattern::kPlain, draft.pick_muted(0.1f, 0.5f));
  const double x = 0.5 * width_m;
  constexpr double kDepth = 0.7;
  draft.builder.add_box({-x, 0.02, 0.71}, {x, kDepth, 0.74}, top);
  draft.builder.add_box({-x + 0.03, 0.06, 0.0}, {-x + 0.08, kDepth - 0.04, 0.71}, steel);
  draft.builder.add_box({x - 0.45, 0.06, 0.02}, {x - 0.03, kDepth - 0.06, 0.71}, steel);
  for (int i = 0; i < 3; ++i) {
    const double z = 0.06 + 0.21 * i;
    draft.builder.add_box({x - 0.44, kDepth - 0.06, z}, {x - 0.04, kDepth - 0.045, z + 0.2}, steel);
  }
  // A screen on its foot, a keyboard, papers.
  const uint32_t black = draft.material(Pattern::kPlain, {0.03f, 0.03f, 0.035f});
  const double s = draft.pick(-0.3, 0.0) * x;
  draft.builder.add_box({s - 0.12, 0.2, 0.74}, {s + 0.12, 0.38, 0.755}, black);
  draft.builder.add_box({s - 0.02, 0.26, 0.755}, {s + 0.02, 0.29, 0.95}, black);
  draft.builder.add_box({s - 0.28, 0.29, 0.86}, {s + 0.28, 0.32, 1.2}, black);
  draft.builder.add_box({s - 0.22, 0.48, 0.74}, {s + 0.22, 0.61, 0.758}, steel);
  const uint32_t paper = draft.material(Pattern::kPoster, {0.75f, 0.75f, 0.72f}, {0.7f, 0.72f, 0.75f});
  draft.edit_material(paper).size_m = {0.21f, 0.297f};
  draft.builder.add_quad({x - 0.35, 0.25, 0.7415}, {0.21, 0.03, 0.0}, {-0.042, 0.294, 0.0}, paper);
}

void add_table(SceneDraft& draft, const Rigid3& frame, double length_m, double width_m) {
  draft.begin("table", frame);
  const uint32_t top = wood_material(draft);
  const uint32_t legs = draft.material(Pattern::kPlain, draft.pick_muted(0.06f, 0.25f));
  const double x = 0.5 * length_m;
  const double y = 0.5 * width_m;
  draft.builder.add_box({-x, -y, 0.71}, {x, y, 0.75}, top);
  add_legs(draft, x - 0.06, y - 0.06, 0.71, 0.07, legs);
  for (int i = 0; i < 4; ++i) {
    const Rigid3 item = frame * placed_at({draft.pick(-x + 0.25, x - 0.25), draft.pick(-y + 0.2, y - 0.2), 0.75},
                                          draft.pick(0.0, M_PI));
    draft.begin("on_table", item);
    if (draft.chance(0.4)) {
      draft.builder.add_box({-0.1, -0.08, 0.0}, {0.1, 0.08, draft.pick(0.08, 0.2)}, cardboard_material(draft));
    } else {
      draft.builder.add_box({-0.12, -0.08, 0.0}, {0.12, 0.08, draft.pick(0.015, 0.05)},
                            draft.material(Pattern::kPlain, draft.pick_color(0.05f, 0.6f)));
    }
  }
}

void add_chair(SceneDraft& draft, const Rigid3& frame) {
  draft.begin("chair", frame);
  const uint32_t seat = draft.material(Pattern::kPlain, draft.pick_color(0.08f, 0.5f));
  const uint32_t steel = draft.material(Pattern::kPlain, draft.pick_color(0.08f, 0.4f));
  draft.builder.add_box({-0.22, -0.21, 0.43}, {0.22, 0.22, 0.47}, seat);
  add_legs(draft, 0.20, 0.20, 0.43, 0.03, steel);
  draft.builder.add_box({-0.2, -0.2, 0.47}, {-0.17, -0.17, 0.86}, steel);
  draft.builder.add_box({0.17, -0.2, 0.47}, {0.2, -0.17, 0.86}, steel);
  draft.builder.add_box({-0.21, -0.215, 0.62}, {0.21, -0.20, 0.88}, seat);
}

void add_plant(SceneDraft& draft, const Rigid3& frame) {
  draft.begin("plant", frame);
  draft.builder.set_has_edges(false);
  const uint32_t pot = draft.material(Pattern::kPlain, draft.pick_color(0.2f, 0.6f));
  const uint32_t trunk = draft.material(Pattern::kPlain, {0.2f, 0.13f, 0.07f});
  std::vector<uint32_t> leaves;
  for (int i = 0; i < 4; ++i) {
    const auto tone = static_cast<float>(draft.pick(0.6, 1.2));
    leaves.push_back(draft.material(Pattern::kPlain, Vector3f(0.10f, 0.30f, 0.07f) * tone));
  }
  draft.builder.add_cylinder({0, 0, 0}, {0, 0, 0.3}, 0.13, 0.17, pot);
  draft.builder.add_cylinder({0, 0, 0.3}, {0, 0, 1.2}, 0.02, 0.012, trunk, 8);
  const double height = draft.pick(1.1, 1.5);
  for (int i = 0; i < 130; ++i) {
    Vector3d center(draft.random.normal(), draft.random.normal(), draft.random.normal());
    center = center.normalized() * (0.34 * std::cbrt(draft.random.uniform()));
    const Vector3d u = Vector3d(draft.random.normal(), draft.random.normal(), draft.random.normal()).normalized();
    const Vector3d v = u.unitOrthogonal();
    const double size = draft.pick(0.04, 0.075);
    const Vector3d corner = Vector3d(0, 0, height) + center;
    const uint32_t leaf = leaves[draft.random.below(leaves.size())];
    draft.builder.add_quad(corner, 1.6 * size * u, size * v, leaf);
    draft.builder.add_quad(corner, size * v, 1.6 * size * u, leaf);  // the underside
  }
}

void add_crates(SceneDraft& draft, const Rigid3& frame, int count) {
  double z = 0.0;
  double half = draft.pick(0.25, 0.38);
  for (int i = 0; i < count; ++i) {
    draft.begin("crate", frame * placed_at({0.0, half + 0.06, z}, draft.pick(-0.12, 0.12)));
    const double height = draft.pick(0.25, 0.45);
    draft.builder.add_box({-half, -0.8 * half, 0.0}, {half, 0.8 * half, height}, cardboard_material(draft));
    z += height;
    half *= draft.pick(0.75, 0.95);
  }
}

void add_radiator(SceneDraft& draft, const Rigid3& frame, double width_m) {
  draft.begin("radiator", frame);
  const uint32_t white = draft.material(Pattern::kPlain, {0.65f, 0.65f, 0.63f});
  const double x = 0.5 * width_m;
  draft.builder.add_box({-x, 0.04, 0.14}, {x, 0.07, 0.7}, white);
  const int fins = static_cast<int>(width_m / 0.08);
  for (int i = 0; i < fins; ++i) {
    const double s = -x + 0.02 + 0.08 * i;
    draft.builder.add_box({s, 0.07, 0.16}, {s + 0.04, 0.1, 0.68}, white);
  }
}

void add_rug(SceneDraft& draft, const Rigid3& frame, double length_m, double width_m) {
  draft.begin("rug", frame);
  const uint32_t rug = draft.material(Pattern::kRug, draft.pick_color(0.08f, 0.4f), draft.pick_color(0.2f, 0.6f));
  draft.edit_material(rug).size_m = {static_cast<float>(length_m), static_cast<float>(width_m)};
  const double x = 0.5 * length_m;
  const double y = 0.5 * width_m;
  draft.builder.add_box({-x, -y, 0.0}, {x, y, 0.006}, rug);
  draft.builder.add_quad({-x, -y, 0.0075}, {length_m, 0, 0}, {0, width_m, 0}, rug);
}

void add_poster(SceneDraft& draft, const Rigid3& frame, double low_m, double width_m, double height_m) {
  draft.begin("poster", frame * placed_at({0.0, 0.0, low_m}, 0.0));
  const uint32_t picture =
      draft.material(Pattern::kPoster, draft.pick_color(0.05f, 0.7f), draft.pick_color(0.05f, 0.7f));
  draft.edit_material(picture).size_m = {static_cast<float>(width_m), static_cast<float>(height_m)};
  const uint32_t rim = draft.material(Pattern::kPlain, draft.pick_color(0.05f, 0.3f));
  add_plate(draft, width_m, height_m, draft.chance(0.5) ? 0.025 : 0.004, picture, rim);
}

void add_whiteboard(SceneDraft& draft, const Rigid3& frame) {
  draft.begin("whiteboard", frame * placed_at({0.0, 0.0, 0.95}, 0.0));
  const uint32_t white = draft.material(Pattern::kSign, {0.7f, 0.7f, 0.7f}, {0.12f, 0.16f, 0.5f});
  draft.edit_material(white).size_m = {1.8f, 0.35f};
  const uint32_t rim = draft.material(Pattern::kPlain, {0.35f, 0.35f, 0.36f});
  add_plate(draft, 1.8, 1.0, 0.03, white, rim);
  draft.builder.add_box({-0.6, 0.03, -0.02}, {0.6, 0.1, 0.0}, rim);
}

void add_bench(SceneDraft& draft, const Rigid3& frame, double length_m) {
  draft.begin("bench", frame);
  const uint32_t wood = wood_material(draft);
  const uint32_t steel = draft.material(Pattern::kPlain, draft.pick_color(0.1f, 0.3f));
  const double x = 0.5 * length_m;
  draft.builder.add_box({-x, 0.05, 0.42}, {x, 0.45, 0.46}, wood);
  draft.builder.add_box({-x, 0.02, 0.6}, {x, 0.05, 0.85}, wood);
  for (const double s : {-x + 0.1, x - 0.15}) {
    draft.builder.add_box({s, 0.05, 0.0}, {s + 0.05, 0.4, 0.42}, steel);
    draft.builder.add_box({s, 0.05, 0.46}, {s + 0.05, 0.08, 0.85}, steel);
  }
}

void add_checkerboard(SceneDraft& draft, const Rigid3& frame, double tilt_rad, double hung_m) {
  SceneCheckerboard board;
  board.name = std::string(1, static_cast<char>('A' + draft.scene.boards.size() % 26));
  board.square_m = 0.09;
  const uint32_t squares = draft.material(Pattern::kCheckerboard, {0.8f, 0.8f, 0.8f}, {0.025f, 0.025f, 0.025f},
                                          static_cast<float>(board.square_m));
  draft.edit_material(squares).cells = {board.inner_columns + 1, board.inner_rows + 1};
  const uint32_t back = draft.material(Pattern::kPlain, {0.5f, 0.5f, 0.5f});
  const double width = (board.inner_columns + 2) * board.square_m;
  const double height = (board.inner_rows + 2) * board.square_m;
  const double low = hung_m > 0.0 ? hung_m : 0.95;
  const Rigid3 plate = tilted_back(frame, {0.0, hung_m > 0.0 ? 0.02 : 0.25, low}, tilt_rad);
  draft.begin("checkerboard", plate);
  constexpr double kThickness = 0.015;
  add_plate(draft, width, height, kThickness, squares, back);
  for (int row = 0; row < board.inner_rows; ++row) {
    for (int column = 0; column < board.inner_columns; ++column) {
      board.corners.push_back(plate * Vector3d(0.5 * width - (1.5 + column) * board.square_m, kThickness,
                                               height - (1.5 + row) * board.square_m));
    }
  }
  draft.scene.boards.push_back(board);
  if (hung_m > 0.0) return;
  draft.begin("tripod", frame);
  draft.builder.set_has_edges(false);
  const uint32_t steel = draft.material(Pattern::kPlain, {0.08f, 0.08f, 0.08f});
  const Vector3d head(0.0, 0.2, 1.0);
  draft.builder.add_cylinder({0.0, 0.2, 0.55}, head, 0.015, 0.015, steel, 8);
  for (int i = 0; i < 3; ++i) {
    const double angle = 2.1 * i + 0.5;
    draft.builder.add_cylinder({0.35 * std::cos(angle), 0.2 + 0.35 * std::sin(angle), 0.0}, {0.0, 0.2, 0.7}, 0.012,
                               0.012, steel, 8);
  }
}

}  // namespace cpplus
