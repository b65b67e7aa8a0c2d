#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "cpplus/core/random.h"
#include "cpplus/simulate/district_plan.h"
#include "cpplus/simulate/district_tile.h"
#include "cpplus/simulate/district_window.h"
#include "cpplus/simulate/path.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Metres to the middle of the nearest street.
double from_street(const DistrictPlan& plan, const Vector2d& place) {
  double nearest = 1e9;
  for (int k = 0; k < plan.num_streets; ++k) {
    nearest = std::min({nearest, std::abs(place.x() - plan.street_m(k)), std::abs(place.y() - plan.street_m(k))});
  }
  return nearest;
}

/// The middle of the district's tile (0, 0) and all around it.
class District : public testing::Test {
 protected:
  void SetUp() override { window_.move_to(middle_); }

  DistrictPlan plan_ = plan_district(0.04, 3);
  Scene surroundings_ = district_surroundings(plan_);
  Vector2d middle_ = Vector2d::Constant(plan_.street_m(0) + 0.5 * plan_.pitch_m);
  DistrictWindow window_{plan_, surroundings_, 100.0};
};

TEST(DistrictPlan, TravelledStreetsStandForTheArea) {
  for (const double area_km2 : {0.01, 0.02, 0.3, 1.0, 16.0}) {
    const DistrictPlan plan = plan_district(area_km2, 1);
    EXPECT_GE(plan.num_streets, 2);
    EXPECT_GE(plan.pitch_m, 50.0 - 1e-9);
    EXPECT_LE(plan.pitch_m, 85.0);
    EXPECT_NEAR(1e-6 * std::pow(plan.num_streets * plan.pitch_m, 2), area_km2, 1e-9);
    EXPECT_NEAR(plan.street_m(0), -plan.street_m(plan.num_streets - 1), 1e-9);
  }
}

TEST(DistrictPlan, ATileIsWhereItsStreetsAre) {
  const DistrictPlan plan = plan_district(0.1, 1);
  for (const int x : {-3, 0, 2}) {
    const Vector2d inside(plan.street_m(x) + 0.01, plan.street_m(x + 2) - 0.01);
    EXPECT_EQ(plan.tile_at(inside), (DistrictTile{x, x + 1}));
  }
  EXPECT_EQ(plan.distance_m({0, 0}, {1, -1}), 0.0);
  EXPECT_NEAR(plan.distance_m({0, 0}, {3, 0}), 2.0 * plan.pitch_m, 1e-9);
}

TEST(DistrictWay, GoesThroughEveryStreetBothWaysAndKeepsToTheStreets) {
  for (const double area_km2 : {0.01, 0.04, 0.09}) {  // 2, 3 and 5 streets
    const DistrictPlan plan = plan_district(area_km2, 1);
    const Path path(district_way(plan));
    std::set<std::pair<int, int>> visited;  // middles of streets between two crossings, in half pitches
    for (double time = 0.0; time < path.duration_s(); time += 0.2) {
      const Vector2d place = path.map_from_lidar(time).translation.head<2>();
      ASSERT_LT(from_street(plan, place), 2.0) << time;
      const Vector2d halves = (place.array() - plan.street_m(0)) / (0.5 * plan.pitch_m);
      const Vector2d nearest(std::round(halves.x()), std::round(halves.y()));
      if ((halves - nearest).norm() * 0.5 * plan.pitch_m > 2.0) continue;
      visited.emplace(static_cast<int>(nearest.x()), static_cast<int>(nearest.y()));
    }
    const int last = 2 * (plan.num_streets - 1);
    for (int street = 0; street <= last; street += 2) {
      for (int half = 1; half < last; half += 2) {
        EXPECT_TRUE(visited.contains({street, half})) << street << " " << half;
        EXPECT_TRUE(visited.contains({half, street})) << half << " " << street;
      }
    }
  }
}

TEST(DistrictTile, IsTheSameWheneverItIsMade) {
  const DistrictPlan plan = plan_district(0.04, 3);
  const Scene one = build_district_tile(plan, {2, -1});
  build_district_tile(plan, {0, 0});
  const Scene two = build_district_tile(plan, {2, -1});
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  ASSERT_EQ(one.materials.size(), two.materials.size());
  for (size_t i = 0; i < one.materials.size(); ++i) {
    EXPECT_EQ(one.materials[i].seed, two.materials[i].seed);
    EXPECT_EQ(one.materials[i].color, two.materials[i].color);
  }
  EXPECT_NE(one.mesh.vertices.size(), build_district_tile(plan, {-1, 2}).mesh.vertices.size());
  DistrictPlan other = plan;
  other.seed = 4;
  EXPECT_NE(one.mesh.vertices.size(), build_district_tile(other, {2, -1}).mesh.vertices.size());
}

TEST(DistrictTile, StaysWithinItsStreets) {
  const DistrictPlan plan = plan_district(0.04, 3);
  const Scene scene = build_district_tile(plan, {1, 0});
  constexpr double kRounding = 1e-5;
  for (const Vector3f& vertex : scene.mesh.vertices) {
    ASSERT_GE(vertex.x(), plan.street_m(1) - kRounding);
    ASSERT_LE(vertex.x(), plan.street_m(2) + kRounding);
    ASSERT_GE(vertex.y(), plan.street_m(0) - kRounding);
    ASSERT_LE(vertex.y(), plan.street_m(1) + kRounding);
  }
}

/// The ground on both sides of a seam and on it, from straight above and from the side: no hole, no step.
TEST_F(District, TheGroundHasNoSeams) {
  Random random(5);
  const double paint = 0.003;
  size_t tried = 0;
  for (int i = 0; i < 200000; ++i) {
    const double along = random.uniform(-60.0, 60.0);
    const double across = i % 3 == 0 ? 0.0 : random.uniform(-0.1, 0.1);
    const int street = static_cast<int>(random.below(4)) - 1;
    const Vector2d ground = i % 2 == 0 ? Vector2d(plan_.street_m(street) + across, along)
                                       : Vector2d(along, plan_.street_m(street) + across);
    const Vector3d eye(ground.x() + random.uniform(-2.0, 2.0), ground.y() + random.uniform(-2.0, 2.0), 1.5);
    const Vector3f ray = (Vector3d(ground.x(), ground.y(), 0.0) - eye).normalized().cast<float>();
    const auto hit = window_.tracer().trace_static(eye.cast<float>(), ray);
    ASSERT_TRUE(hit.has_value());
    if (hit->point.z() > 0.2f) continue;  // a car
    ++tried;
    ASSERT_NEAR(hit->point.z(), 0.5 * paint, 0.5 * paint + 1e-5) << ground.transpose();
  }
  EXPECT_GT(tried, 150000u);
}

/// Two tiles each paint half of what is in the middle of the street between them.
TEST_F(District, PaintIsTheSameOnBothSidesOfASeam) {
  size_t painted = 0;
  const auto is_paint = [&](const Vector2d& place) {
    const auto hit =
        window_.tracer().trace_static(Vector3d(place.x(), place.y(), 1.0).cast<float>(), -Vector3f::UnitZ());
    return hit->point.z() > 0.001f && hit->point.z() < 0.003f;
  };
  for (int street = -1; street <= 2; ++street) {
    for (double along = -60.017; along < 60.0; along += 0.13) {
      for (const double across : {0.03, 0.5, 1.5, 2.5}) {
        const double x = plan_.street_m(street);
        const bool one = is_paint({x - across, along});
        EXPECT_EQ(one, is_paint({x + across, along})) << x << " " << along << " " << across;
        EXPECT_EQ(is_paint({along, x - across}), is_paint({along, x + across})) << x << " " << along << " " << across;
        painted += one ? 1 : 0;
      }
    }
  }
  EXPECT_GT(painted, 200u);
}

TEST_F(District, TheWayIsClear) {
  const Path path(surroundings_.way);
  DistrictWindow window(plan_, surroundings_, 30.0);
  Vector3d last = path.map_from_lidar(0.0).translation;
  for (double time = 0.0; time < path.duration_s(); time += 0.25) {
    const Vector3d place = path.map_from_lidar(time).translation;
    window.move_to(place.head<2>());
    const Vector3d step = place - last;
    if (time > 0.0) {
      ASSERT_FALSE(window.tracer().occluded_static(last.cast<float>(), step.normalized().cast<float>(),
                                                   static_cast<float>(step.norm())));
    }
    last = place;
    for (int i = 0; i < 16; ++i) {
      const double angle = 2.0 * M_PI * i / 16;
      ASSERT_FALSE(window.tracer().occluded_static(
          place.cast<float>(), Vector3d(std::cos(angle), std::sin(angle), -0.3).normalized().cast<float>(), 0.6f))
          << place.transpose();
    }
  }
}

/// What lies around a place does not depend on where the window was before, nor on how far it reaches beyond.
TEST_F(District, AWindowShowsTheSameHoweverItCame) {
  DistrictWindow other(plan_, surroundings_, 140.0);
  other.move_to(middle_ + Vector2d(2.0 * plan_.pitch_m, plan_.pitch_m));
  other.move_to(middle_);
  EXPECT_GT(other.num_tiles(), window_.num_tiles());
  const Vector3f eye = Vector3d(middle_.x(), plan_.street_m(0) - 1.3, 1.7).cast<float>();
  Random random(6);
  size_t hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3f ray = Vector3d(random.normal(), random.normal(), 0.3 * random.normal()).normalized().cast<float>();
    const auto a = window_.tracer().trace_static(eye, ray, 100.0f);
    const auto b = other.tracer().trace_static(eye, ray, 100.0f);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    ++hits;
    ASSERT_EQ(a->range, b->range);
    ASSERT_EQ(a->normal, b->normal);
    ASSERT_EQ(a->material->seed, b->material->seed);
  }
  EXPECT_GT(hits, 15000u);
}

/// Few tiles are there at a time, all of them near.
TEST_F(District, FarTilesAreGone) {
  const size_t at_first = window_.num_tiles();
  window_.move_to(middle_ + Vector2d(20.0 * plan_.pitch_m, 0.0));
  EXPECT_EQ(window_.num_tiles(), at_first);
  const Vector3f above = Vector3d(middle_.x(), middle_.y(), 100.0).cast<float>();
  EXPECT_FALSE(window_.tracer().trace_static(above, -Vector3f::UnitZ()).has_value());
}

}  // namespace
}  // namespace cpplus
