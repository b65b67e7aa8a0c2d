#include "cpplus/pipeline/image_groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cpplus/cloud/map_part.h"

namespace cpplus {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// One point in each root of a row along x.
VoxelMap row_of_roots(int num_roots) {
  PointCloud cloud;
  for (int i = 0; i < num_roots; ++i) cloud.positions.emplace_back(2.0f * static_cast<float>(i) + 1.0f, 1.0f, 1.0f);
  return VoxelMap(cloud, {});
}

Eigen::Vector3d at(double x) { return {x, 1.0, 1.0}; }

TEST(ImageGroups, OneWhereTheMapAroundAllIsSmallEnough) {
  const VoxelMap map = row_of_roots(20);
  const std::vector<Eigen::Vector3d> places = {at(31), at(1), at(11)};
  // Within 3 m of each: roots -2..2 of which five, three at the border, and five.
  EXPECT_THAT(group_images(map, places, 3.5, 13), ElementsAre(ElementsAre(0, 1, 2)));
  EXPECT_THAT(group_images(map, {}, 3.5, 13), IsEmpty());
}

TEST(ImageGroups, AreHalvedAlongTheLongestExtentUntilTheyAreSmallEnough) {
  const VoxelMap map = row_of_roots(20);
  const std::vector<Eigen::Vector3d> places = {at(31), at(1), at(11), at(33)};
  EXPECT_THAT(group_images(map, places, 3.5, 12), ElementsAre(ElementsAre(1, 2), ElementsAre(0, 3)));
  EXPECT_THAT(group_images(map, places, 3.5, 7), ElementsAre(ElementsAre(1), ElementsAre(2), ElementsAre(0, 3)));
}

TEST(ImageGroups, ImagesThatHaveTheSameAroundThemStayTogetherHoweverMuchThatIs) {
  const VoxelMap map = row_of_roots(20);
  EXPECT_THAT(group_images(map, {at(11), at(11), at(12)}, 3.5, 1), ElementsAre(ElementsAre(0, 1, 2)));
  EXPECT_THAT(group_images(map, {at(11), at(500), at(11)}, 3.5, 1), ElementsAre(ElementsAre(0, 2), ElementsAre(1)));
}

}  // namespace
}  // namespace cpplus
