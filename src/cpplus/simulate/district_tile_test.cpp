#include "cpplus/simulate/district_tile.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

using Eigen::Vector3f;

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

}  // namespace
}  // namespace cpplus
