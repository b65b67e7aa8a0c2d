#include "cpplus/visibility/hidden_point_removal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using testing::ElementsAre;

TEST(HiddenPointRemoval, OfTwoPointsOnARayTheNearerHidesTheOther) {
  const std::vector<Eigen::Vector3d> points = {{0, 0, 2}, {0, 0, 3}, {1, 0, 2}, {-1, 0, 2}, {0, 1, 2}, {0, -1, 2}};
  EXPECT_THAT(remove_hidden_points(points, 2.0), ElementsAre(0, 2, 3, 4, 5));
}

TEST(HiddenPointRemoval, SeesThroughAGapAsComputedByHand) {
  // Four points at distance sqrt(5), 1 m around the axis at z = 2, and one on the axis at z = 20 = max |p|. Flipped,
  // the four lie at z = 2 (2 R / sqrt(5) - 1), the fifth at z = 2 R - 20. It is on the hull where it lies beyond the
  // four's plane, 2 R (1 - 2 / sqrt(5)) > 18, that is R > 85.2 m = 4.26 max |p|.
  const std::vector<Eigen::Vector3d> points = {{-1, 0, 2}, {1, 0, 2}, {0, -1, 2}, {0, 1, 2}, {0, 0, 20}};
  EXPECT_THAT(remove_hidden_points(points, 4.25), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(remove_hidden_points(points, 4.27), ElementsAre(0, 1, 2, 3, 4));
}

TEST(HiddenPointRemoval, SeesTheNearSideOfABall) {
  Random random(3);
  std::vector<Eigen::Vector3d> points;
  std::vector<bool> truth;
  const Eigen::Vector3d center(0, 0, 5);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d normal = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    points.push_back(center + normal);
    truth.push_back(normal.dot(-points.back()) > 0.0);
  }
  const std::vector<uint32_t> visible = remove_hidden_points(points, 30.0);
  size_t right = 0;
  for (const uint32_t i : visible) right += truth[i];
  const auto num_true = static_cast<double>(std::count(truth.begin(), truth.end(), true));
  EXPECT_GT(static_cast<double>(right), 0.9 * num_true);
  EXPECT_GT(static_cast<double>(right), 0.97 * static_cast<double>(visible.size()));
}

TEST(HiddenPointRemoval, ALargerSphereKeepsMore) {
  Random random(4);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 5000; ++i) points.push_back({random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(1, 9)});
  size_t last = 0;
  for (const double factor : {0.5, 3.0, 30.0, 300.0}) {
    const size_t count = remove_hidden_points(points, factor).size();
    EXPECT_GT(count, last) << factor;
    last = count;
  }
}

TEST(HiddenPointRemoval, KeepsAllWhereThereIsNoHull) {
  EXPECT_TRUE(remove_hidden_points({}, 1.0).empty());
  EXPECT_THAT(remove_hidden_points({{0, 0, 1}}, 1.0), ElementsAre(0));
  EXPECT_THAT(remove_hidden_points({{0, 0, 1}, {0, 1, 1}, {0, 2, 1}, {0, 3, 1}, {0, -3, 1}}, 1.0),
              ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(remove_hidden_points({{0, 0, 0}, {0, 0, 1}}, 1.0), ElementsAre(1));
}

TEST(HiddenPointRemoval, RefusesBadInput) {
  EXPECT_THROW(remove_hidden_points({{0, 0, 1}}, 0.4), Error);
  EXPECT_THROW(remove_hidden_points({{0, 0, std::nan("")}}, 1.0), Error);
}

}  // namespace
}  // namespace cpplus
