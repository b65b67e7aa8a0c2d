#include "cpplus/simulate/district_window.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/random.h"
#include "cpplus/simulate/district_tile.h"
#include "cpplus/simulate/path.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// The middle of the district's tile (0, 0) and all around it.
class DistrictWindowTest : public testing::Test {
 protected:
  void SetUp() override { window_.move_to(middle_); }

  DistrictPlan plan_ = plan_district(0.04, 3);
  Scene surroundings_ = district_surroundings(plan_);
  Vector2d middle_ = Vector2d::Constant(plan_.street_m(0) + 0.5 * plan_.pitch_m);
  DistrictWindow window_{plan_, surroundings_, 100.0};
};

/// The ground on both sides of a seam and on it, from straight above and from the side: no hole, no step.
TEST_F(DistrictWindowTest, TheGroundHasNoSeams) {
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
TEST_F(DistrictWindowTest, PaintIsTheSameOnBothSidesOfASeam) {
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

TEST_F(DistrictWindowTest, TheWayIsClear) {
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
TEST_F(DistrictWindowTest, AWindowShowsTheSameHoweverItCame) {
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
TEST_F(DistrictWindowTest, FarTilesAreGone) {
  const size_t at_first = window_.num_tiles();
  window_.move_to(middle_ + Vector2d(20.0 * plan_.pitch_m, 0.0));
  EXPECT_EQ(window_.num_tiles(), at_first);
  const Vector3f above = Vector3d(middle_.x(), middle_.y(), 100.0).cast<float>();
  EXPECT_FALSE(window_.tracer().trace_static(above, -Vector3f::UnitZ()).has_value());
}

}  // namespace
}  // namespace cpplus
