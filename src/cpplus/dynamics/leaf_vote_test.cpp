#include "cpplus/dynamics/leaf_vote.h"

#include <gmock/gmock.h>

namespace cpplus {
namespace {

using testing::ElementsAre;

/// Leaves in a row along x, 0.1 m wide, all within the word of one another.
VoxelMap row_of_leaves(int count) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) cloud.positions.emplace_back(0.1f * static_cast<float>(i) + 0.05f, 0.05f, 0.05f);
  VoxelMapOptions options;
  options.root_size_m = 0.8;
  options.leaf_size_m = 0.1;
  return VoxelMap(cloud, options);
}

TEST(LeafVote, ALeafNeedsAShareOfTheScansThatHitIt) {
  DynamicsOptions options;
  options.keep_share = 0.0;
  options.fill_share = 1.0;
  options.min_share = 0.25;
  const VoxelMap map = row_of_leaves(4);
  EXPECT_THAT(vote_on_leaves(map, {1, 8, 8, 8}, {0, 1, 2, 3}, options), ElementsAre(0, 0, 1, 1));
}

TEST(LeafVote, MoreThanSufficientScansChangeNothing) {
  DynamicsOptions options;
  options.sure_scans = 2;
  options.min_share = 0.25;
  EXPECT_EQ(sufficient_scans(1, options), 2u);
  EXPECT_EQ(sufficient_scans(8, options), 2u);
  EXPECT_EQ(sufficient_scans(9, options), 3u);
  const VoxelMap map = row_of_leaves(4);
  EXPECT_EQ(vote_on_leaves(map, {1, 8, 9, 40}, {2, 2, 3, 9}, options),
            vote_on_leaves(map, {1, 8, 9, 40}, {50, 60, 70, 9}, options));
}

TEST(LeafVote, ALeafAmongDynamicOnesIsFilled) {
  const VoxelMap map = row_of_leaves(4);
  DynamicsOptions options;
  options.fill_share = 0.6;
  EXPECT_THAT(vote_on_leaves(map, {1, 1, 1, 1}, {5, 0, 5, 5}, options), ElementsAre(1, 1, 1, 1));
  // One of three around each of the others: too few.
  EXPECT_THAT(vote_on_leaves(map, {1, 1, 1, 1}, {5, 0, 0, 0}, options), ElementsAre(1, 0, 0, 0));
}

TEST(LeafVote, ALonelyUnsureLeafIsStatic) {
  const VoxelMap map = row_of_leaves(4);
  DynamicsOptions options;
  options.sure_scans = 2;
  options.fill_share = 1.0;
  EXPECT_THAT(vote_on_leaves(map, {1, 1, 1, 1}, {1, 0, 0, 0}, options), ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(vote_on_leaves(map, {1, 1, 1, 1}, {2, 0, 0, 0}, options), ElementsAre(1, 0, 0, 0));
  EXPECT_THAT(vote_on_leaves(map, {1, 1, 1, 1}, {1, 2, 0, 0}, options), ElementsAre(1, 1, 0, 0));
}

}  // namespace
}  // namespace cpplus
