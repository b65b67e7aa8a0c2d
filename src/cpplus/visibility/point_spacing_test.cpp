#include "cpplus/visibility/point_spacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/visibility/scene_test_util.h"

namespace cpplus {
namespace {

// Spacing in most leaves of a wall of 4 x 4 m.
double spacing_on_wall(double true_spacing_m) {
  Random random(1);
  PointCloud cloud;
  add_rectangle({0.01, 0.01, 0.03}, {4, 0, 0}, {0, 4, 0}, true_spacing_m, 0.0, &random, &cloud);
  std::vector<float> spacing = leaf_point_spacing(VoxelMap(cloud, {}));
  std::nth_element(spacing.begin(), spacing.begin() + static_cast<std::ptrdiff_t>(spacing.size() / 2), spacing.end());
  return static_cast<double>(spacing[spacing.size() / 2]);
}

TEST(LeafPointSpacing, IsThatOfTheSurfaceWhetherLeavesHoldManyPointsOrFew) {
  for (const double spacing : {0.01, 0.02, 0.05, 0.1}) {
    EXPECT_NEAR(spacing_on_wall(spacing), spacing, 0.2 * spacing) << spacing;
  }
}

TEST(LeafPointSpacing, LonelyPointsAreNoSurface) {
  PointCloud cloud;
  cloud.positions = {{0.1f, 0.1f, 0.1f}, {3.1f, 0.1f, 0.1f}, {3.2f, 0.3f, 0.1f}};
  for (const float spacing : leaf_point_spacing(VoxelMap(cloud, {}))) EXPECT_TRUE(std::isinf(spacing));
}

TEST(LeafPointSpacing, AnEmptyMapHasNone) { EXPECT_TRUE(leaf_point_spacing(VoxelMap()).empty()); }

}  // namespace
}  // namespace cpplus
