#include "cpplus/simulate/district_tile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cpplus/simulate/facade.h"
#include "cpplus/simulate/furniture.h"
#include "cpplus/simulate/hash.h"
#include "cpplus/simulate/scene_draft.h"
#include "cpplus/simulate/traffic.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHouseDepth = 8.0;

struct GroundMaterials {
  uint32_t asphalt;
  uint32_t paving;
  uint32_t kerb;
  uint32_t paint;
};

/// The same in all tiles: surfaces go on across their borders.
GroundMaterials ground_materials(SceneDraft& draft) {
  GroundMaterials ground{};
  ground.asphalt = draft.material(Pattern::kAsphalt, {0.085f, 0.085f, 0.09f});
  ground.paving = draft.material(Pattern::kTiles, draft.pick_muted(0.35f, 0.45f), {0.14f, 0.14f, 0.14f}, 0.5f);
  ground.kerb = draft.material(Pattern::kPlaster, {0.48f, 0.47f, 0.45f});
  ground.paint = draft.material(Pattern::kPlain, {0.7f, 0.7f, 0.68f});
  draft.edit_material(ground.paint).lidar_reflectance = 1.6f;
  return ground;
}

/// A tile under construction. Each of its four sides has a frame: x along the street, y towards it, the origin in the
/// middle of the tile.
class TileBuilder {
 public:
  TileBuilder(const DistrictPlan& plan, const DistrictTile& tile)
      : plan_(plan),
        tile_(tile),
        half_(0.5 * plan.pitch_m),
        kerb_line_(half_ - plan.road_m),
        front_(kerb_line_ - plan.pavement_m),
        draft_("district", plan.seed),
        ground_(ground_materials(draft_)) {
    draft_.random = Random(hash_seed(hash_seed(plan.seed, 0x711E), index_hash(tile.x), index_hash(tile.y)));
  }

  Scene build() {
    add_ground();
    for (int side = 0; side < 4; ++side) {
      add_markings(side);
      add_houses(side);
      add_roadside(side);
      add_parked_cars(side);
    }
    add_courtyard();
    return std::move(draft_.scene);
  }

 private:
  static uint64_t index_hash(int index) { return static_cast<uint64_t>(static_cast<int64_t>(index)); }

  Vector3d middle() const { return {plan_.street_m(tile_.x) + half_, plan_.street_m(tile_.y) + half_, 0.0}; }
  Rigid3 side_frame(int side) const { return placed_at(middle(), 0.5 * M_PI * side); }

  void add_ground() {
    const double x0 = plan_.street_m(tile_.x), x1 = plan_.street_m(tile_.x + 1);
    const double y0 = plan_.street_m(tile_.y), y1 = plan_.street_m(tile_.y + 1);
    draft_.begin("road");
    draft_.builder.add_polygon({{x0, y0, 0.0}, {x1, y0, 0.0}, {x1, y1, 0.0}, {x0, y1, 0.0}}, ground_.asphalt);
    constexpr double kKerbWidth = 0.15;
    const double r = plan_.road_m, k = plan_.road_m + kKerbWidth, top = plan_.kerb_m;
    draft_.begin("kerb");
    draft_.builder.add_box({x0 + r, y0 + r, -0.3}, {x1 - r, y0 + k, top}, ground_.kerb);
    draft_.builder.add_box({x0 + r, y1 - k, -0.3}, {x1 - r, y1 - r, top}, ground_.kerb);
    draft_.builder.add_box({x0 + r, y0 + k, -0.3}, {x0 + k, y1 - k, top}, ground_.kerb);
    draft_.builder.add_box({x1 - k, y0 + k, -0.3}, {x1 - r, y1 - k, top}, ground_.kerb);
    draft_.begin("pavement");
    draft_.builder.add_box({x0 + k, y0 + k, -0.3}, {x1 - k, y1 - k, top}, ground_.paving);
  }

  /// Whether a crossing for pedestrians leads over the street that leaves a crossing of streets to the east (0), north,
  /// west or south. Both tiles beside the street ask.
  bool has_zebra(int street_x, int street_y, int direction) const {
    const uint64_t place = hash_seed(index_hash(street_x), index_hash(street_y), static_cast<uint64_t>(direction));
    return hash_uniform(hash_seed(plan_.seed, 0x2EB4, place)) < 0.5f;
  }

  /// This tile's half of the paint on the street of a side.
  void add_markings(int side) {
    constexpr double kPaint = 0.002;
    constexpr double kLine = 0.06;  // half width
    draft_.begin("markings", side_frame(side));
    draft_.builder.set_has_edges(false);
    const double end = kerb_line_ - 5.0;
    for (double x = 1.5; x < end; x += 6.0) {
      const double length = std::min(3.0, end - x);
      for (const double begin : {x, -x - length}) {
        draft_.builder.add_quad({begin, half_ - kLine, kPaint}, {length, 0, 0}, {0, kLine, 0}, ground_.paint);
      }
    }
    for (const int sign : {-1, 1}) {
      // Quarter turns of (sign, 1): which corner of the tile this is, and which way its street leads from there.
      Eigen::Vector2i corner(sign, 1);
      for (int turn = 0; turn < side; ++turn) corner = Eigen::Vector2i(-corner.y(), corner.x());
      const int direction = (side + (sign > 0 ? 2 : 0)) % 4;
      if (!has_zebra(tile_.x + (corner.x() > 0 ? 1 : 0), tile_.y + (corner.y() > 0 ? 1 : 0), direction)) continue;
      const double begin = sign > 0 ? kerb_line_ - 4.3 : -kerb_line_ + 0.8;
      for (double y = half_ - 0.75; y > kerb_line_ + 0.3; y -= 1.0) {
        draft_.builder.add_quad({begin, y, kPaint}, {3.5, 0, 0}, {0, 0.5, 0}, ground_.paint);
      }
    }
  }

  /// A row of houses from one corner of the block to where the row of the side before it stands.
  void add_houses(int side) {
    const double length = 2.0 * front_ - kHouseDepth;
    const int count = std::max(1, static_cast<int>(std::lround(length / 11.0)));
    std::vector<double> gaps, widths;
    double free = length, total = 0.0;
    for (int i = 0; i < count; ++i) {
      gaps.push_back(i == 0 ? 0.0 : draft_.chance(0.15) ? draft_.pick(2.0, 3.5) : 0.02);
      widths.push_back(draft_.pick(0.8, 1.25));
      free -= gaps.back();
      total += widths.back();
    }
    double x = -front_;
    for (int i = 0; i < count; ++i) {
      FacadeOptions house;
      house.depth_m = kHouseDepth;
      house.width_m = widths[static_cast<size_t>(i)] * free / total;
      house.floors = 2 + static_cast<int>(draft_.random.below(4));
      house.shop = draft_.chance(0.5);
      const bool at_corner = i == 0 || i + 1 == count;
      const double back = !at_corner && draft_.chance(0.3) ? draft_.pick(0.3, 0.8) : 0.0;
      x += gaps[static_cast<size_t>(i)];
      add_house(draft_, side_frame(side) * placed_at({x, front_ - back, plan_.kerb_m}, 0.0), house);
      x += house.width_m;
    }
  }

  void add_roadside(int side) {
    const double y = kerb_line_ - 0.9;
    const Rigid3 frame = side_frame(side);
    const double yaw = 0.5 * M_PI * side;
    for (double x = -kerb_line_ + draft_.pick(2.0, 6.0); x < kerb_line_ - 2.0; x += draft_.pick(9.0, 14.0)) {
      const Vector3d place = frame * Vector3d(x, y, plan_.kerb_m);
      const double dice = draft_.random.uniform();
      if (dice < 0.5) {
        add_tree(draft_, place, draft_.pick(4.5, 6.5));
      } else if (dice < 0.8) {
        add_street_lamp(draft_, place, yaw);
      } else {
        add_traffic_sign(draft_, place, yaw - 0.5 * M_PI);
      }
    }
    if (draft_.chance(0.5)) {
      add_bench(draft_, frame * placed_at({draft_.pick(-5.0, 5.0), front_ + 0.3, plan_.kerb_m}, 0.0), 1.6);
    }
  }

  /// Clear of the crossings and of the zebras before them.
  void add_parked_cars(int side) {
    constexpr double kFromCorner = 8.0;
    const double end = kerb_line_ - kFromCorner;
    for (double x = -end + draft_.pick(0.0, 4.0); x < end; x += draft_.pick(5.5, 11.0)) {
      // Right-hand traffic: the block is to the right of the car.
      add_parked_car(draft_, side_frame(side) * placed_at({x, kerb_line_ + 1.1, 0.0}, 0.0));
    }
  }

  void add_courtyard() {
    const double reach = front_ - kHouseDepth - 2.5;
    const int trees = reach > 0.0 ? 1 + static_cast<int>(draft_.random.below(3)) : 0;
    for (int i = 0; i < trees; ++i) {
      const Vector3d offset(draft_.pick(-reach, reach), draft_.pick(-reach, reach), plan_.kerb_m);
      add_tree(draft_, middle() + offset, draft_.pick(4.5, 7.0));
    }
  }

  const DistrictPlan& plan_;
  DistrictTile tile_;
  double half_;       // of the pitch
  double kerb_line_;  // from the middle of the tile
  double front_;      // of the houses, from the middle of the tile
  SceneDraft draft_;
  GroundMaterials ground_;
};

}  // namespace

Scene district_surroundings(const DistrictPlan& plan) {
  SceneDraft draft("district", plan.seed);
  Sky& sky = draft.scene.sky;
  const double angle = draft.pick(0.0, 2.0 * M_PI);
  sky.sun_direction =
      Vector3d(0.75 * std::cos(angle), 0.75 * std::sin(angle), draft.pick(0.7, 1.1)).normalized().cast<float>();
  sky.sun_irradiance = {4.2f, 3.9f, 3.4f};
  sky.ambient = Eigen::Vector3f::Constant(0.28f);
  sky.ambient_reach_m = 6.0f;
  draft.scene.light_cell_m = 0.2f;
  draft.scene.way = district_way(plan);
  return draft.scene;
}

Scene build_district_tile(const DistrictPlan& plan, const DistrictTile& tile) {
  return TileBuilder(plan, tile).build();
}

}  // namespace cpplus
