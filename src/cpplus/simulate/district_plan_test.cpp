#include "cpplus/simulate/district_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "cpplus/simulate/path.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;

/// Metres to the middle of the nearest street.
double from_street(const DistrictPlan& plan, const Vector2d& place) {
  double nearest = 1e9;
  for (int k = 0; k < plan.num_streets; ++k) {
    nearest = std::min({nearest, std::abs(place.x() - plan.street_m(k)), std::abs(place.y() - plan.street_m(k))});
  }
  return nearest;
}

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

TEST(DistrictWay, GoesThroughEveryStreetAndKeepsToTheStreets) {
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

}  // namespace
}  // namespace cpplus
