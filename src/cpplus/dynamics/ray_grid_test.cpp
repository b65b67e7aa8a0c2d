#include "cpplus/dynamics/ray_grid.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Eigen::Vector3f;

Vector3f random_direction(Random* random) {
  return Eigen::Vector3d(random->normal(), random->normal(), random->normal()).normalized().cast<float>();
}

/// The length of a ray inside a cube, negative where it misses: by clipping at the three pairs of sides, in double.
double chord(const ScanRay& ray, const SensorCube& cube) {
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double low = static_cast<double>(cube.center[a]) - cube.half_m;
    const double high = static_cast<double>(cube.center[a]) + cube.half_m;
    const double direction = ray.direction[a];
    enter = std::max(enter, std::min(low / direction, high / direction));
    leave = std::min(leave, std::max(low / direction, high / direction));
  }
  return leave - enter;
}

TEST(SensorCube, DistanceIsThatOfTheNearestPoint) {
  EXPECT_FLOAT_EQ((SensorCube{{3.0f, 0.0f, 0.0f}, 1.0f}.distance()), 2.0f);
  EXPECT_FLOAT_EQ((SensorCube{{-4.0f, 5.0f, 0.5f}, 1.0f}.distance()), 5.0f);  // the edge at (-3, 4)
  EXPECT_FLOAT_EQ((SensorCube{{0.5f, 0.5f, 0.5f}, 1.0f}.distance()), 0.0f);
}

TEST(LineMeets, TheCubeOfAHandDrawing) {
  const SensorCube cube{{4.0f, 2.0f, 0.0f}, 1.0f};  // x 3 to 5, y 1 to 3: slopes 1/5 to 1
  const auto meets = [&](float slope) { return line_meets(Vector3f(1.0f, slope, 0.0f).normalized(), cube); };
  EXPECT_TRUE(meets(0.5f));
  EXPECT_TRUE(meets(0.21f));
  EXPECT_FALSE(meets(0.19f));
  EXPECT_TRUE(meets(0.99f));
  EXPECT_FALSE(meets(1.01f));
  EXPECT_FALSE(line_meets(Vector3f(1.0f, 0.5f, 0.4f).normalized(), cube));
}

TEST(RayGrid, ReachIsTheLongestRayAtTheCube) {
  RayGrid grid;
  grid.assign({{Vector3f::UnitX(), 7.0f}, {-Vector3f::UnitX(), 9.0f}, {Vector3f::UnitZ(), 3.0f}});
  EXPECT_EQ(grid.reach({{5.0f, 0.0f, 0.0f}, 0.1f}), 7.0f);
  EXPECT_EQ(grid.reach({{-5.0f, 0.0f, 0.0f}, 0.1f}), 9.0f);
  EXPECT_EQ(grid.reach({{0.0f, 0.0f, 5.0f}, 0.1f}), 3.0f);
  EXPECT_EQ(grid.reach({{0.0f, 5.0f, 0.0f}, 0.1f}), 0.0f);
  EXPECT_EQ(grid.reach({{0.1f, 0.0f, 0.0f}, 0.1f}), std::numeric_limits<float>::infinity());
}

TEST(RayGrid, WithoutRaysNothingIsReached) {
  RayGrid grid;
  grid.assign({});
  EXPECT_EQ(grid.reach({{5.0f, 1.0f, -2.0f}, 0.5f}), 0.0f);
  EXPECT_FALSE(grid.any_ray({{5.0f, 1.0f, -2.0f}, 0.5f}, [](const ScanRay&) { return true; }));
}

TEST(RayGrid, FindsWhatATestOfEveryRayFinds) {
  Random random(3);
  for (const size_t num_rays : {1, 30, 5000, 60000}) {
    std::vector<ScanRay> rays(num_rays);
    // The length is the ray's number, so that the test below knows which ray it is asked about.
    for (size_t i = 0; i < num_rays; ++i) rays[i] = {random_direction(&random), static_cast<float>(i + 1)};
    RayGrid grid;
    grid.assign(rays);
    size_t num_met = 0;
    for (int i = 0; i < 200; ++i) {
      const auto half = static_cast<float>(std::exp(random.uniform(-4.0, 1.0)));
      const SensorCube cube{static_cast<float>(random.uniform(0.0, 15.0)) * random_direction(&random), half};
      std::vector<bool> asked(num_rays, false);
      const bool found = grid.any_ray(cube, [&](const ScanRay& ray) {
        const size_t number = static_cast<size_t>(ray.length_m) - 1;
        EXPECT_FALSE(asked[number]) << "asked twice";
        asked[number] = true;
        return false;
      });
      EXPECT_FALSE(found);
      float longest = 0.0f;
      for (size_t k = 0; k < num_rays; ++k) {
        const double inside = chord(rays[k], cube);
        if (std::abs(inside) < 1e-4) continue;  // touches

        if (inside <= 0.0) continue;
        EXPECT_TRUE(line_meets(rays[k].direction, cube));
        ++num_met;
        longest = rays[k].length_m;
        EXPECT_TRUE(asked[k]) << inside;
      }
      EXPECT_GE(grid.reach(cube), longest);
    }
    EXPECT_GT(num_met, num_rays / 10);
  }
}

}  // namespace
}  // namespace cpplus
