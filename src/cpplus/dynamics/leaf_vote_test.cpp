#include "cpplus/dynamics/leaf_vote.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>

#include "cpplus/dynamics/region_hits.h"

namespace cpplus {
namespace {

using testing::ElementsAre;

VoxelMapOptions small_leaves() {
  VoxelMapOptions options;
  options.root_size_m = 0.8;
  options.leaf_size_m = 0.1;
  return options;
}

Eigen::Vector3f leaf_center(int leaf) { return {0.1f * static_cast<float>(leaf) + 0.05f, 0.05f, 0.05f}; }

/// Leaves in a row along x, 0.1 m wide, all within the word of one another.
VoxelMap row_of_leaves(int count) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) cloud.positions.push_back(leaf_center(i));
  return VoxelMap(cloud, small_leaves());
}

/// As many scans as a leaf of a row has hits, each of which hits all leaves up to the one that has so many.
struct Hits {
  ScanSet scans;
  LeafSurfaces surfaces;
  std::optional<VoxelMap> map;

  /// `on_plane` says which leaves lie on one.
  Hits(const std::vector<uint32_t>& num_hits, const std::vector<bool>& on_plane) {
    const uint32_t num_scans = *std::max_element(num_hits.begin(), num_hits.end());
    for (uint32_t scan = 0; scan < num_scans; ++scan) {
      for (size_t leaf = 0; leaf < num_hits.size(); ++leaf) {
        if (scan < num_hits[leaf]) scans.points.positions.push_back(leaf_center(static_cast<int>(leaf)));
      }
      scans.first_point.push_back(scans.points.size());
      scans.sensors_in_map.emplace_back(0, 0, 0);
    }
    map.emplace(scans.points, small_leaves());
    surfaces = measure_leaf_surfaces(*map, scans);
    for (size_t leaf = 0; leaf < num_hits.size(); ++leaf) {
      surfaces.normals[leaf] = on_plane[leaf] ? Eigen::Vector3f::UnitZ().eval() : Eigen::Vector3f::Zero().eval();
    }
  }

  std::vector<uint8_t> vote(const std::vector<uint32_t>& num_through, const DynamicsOptions& options) const {
    return vote({num_through, std::vector<uint32_t>(num_through.size(), 0)}, options);
  }
  std::vector<uint8_t> vote(const SeeThrough& seen, const DynamicsOptions& options) const {
    return vote_on_leaves(*map, scans, surfaces, seen, options);
  }
};

DynamicsOptions alone() {
  DynamicsOptions options;
  options.keep_share = 0.0;
  return options;
}

TEST(LeafVote, ALeafNeedsAShareOfTheScansThatHitIt) {
  DynamicsOptions options = alone();
  options.min_share = 0.25;
  options.region_share = 0.0;
  const Hits hits({1, 1, 8, 8}, {false, false, false, false});
  EXPECT_THAT(hits.vote({0, 0, 1, 3}, options), ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(hits.vote({0, 0, 1, 2}, options), ElementsAre(0, 0, 0, 1));
}

TEST(LeafVote, ALeafNeedsAShareOfTheScansThatHitSomethingAroundIt) {
  DynamicsOptions options = alone();
  options.region_share = 0.25;
  EXPECT_THAT(Hits({1, 1, 8, 1}, {false, false, false, false}).vote({1, 0, 0, 2}, options), ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(Hits({1, 1, 8, 1}, {false, false, true, false}).vote({1, 0, 0, 2}, options), ElementsAre(1, 0, 0, 1))
      << "a plane is no part of what stands or moves there";
}

TEST(LeafVote, RaysBesideALeafNeedMoreScans) {
  DynamicsOptions options = alone();
  options.near_share = 2.0;
  const Hits lonely({1, 1, 1, 1}, {false, false, false, false});
  EXPECT_THAT(lonely.vote({{0, 0, 0, 0}, {1, 2, 0, 7}}, options), ElementsAre(0, 1, 0, 1)) << "one scan is too few";
  const Hits crowded({1, 1, 3, 1}, {false, false, false, false});
  EXPECT_THAT(crowded.vote({{0, 0, 0, 0}, {5, 6, 0, 7}}, options), ElementsAre(0, 1, 0, 1))
      << "three scans hit something there: twice as many must pass";
}

TEST(RegionHits, CountsScansOnceAndOnlyWhereAskedFor) {
  const Hits hits({3, 5, 2, 4}, {false, false, true, false});
  EXPECT_THAT(count_region_hits(*hits.map, hits.scans, hits.surfaces, {1, 0, 0, 1}), ElementsAre(5, 0, 0, 5));
}

TEST(LeafVote, MoreThanSufficientScansChangeNothing) {
  DynamicsOptions options;
  options.sure_share = 1.5;
  options.min_share = 0.25;
  options.region_share = 0.25;
  EXPECT_EQ(sufficient_scans(1, 8, options), 2u);
  EXPECT_EQ(sufficient_scans(9, 9, options), 14u);
  EXPECT_EQ(sufficient_scans(1, 40, options), 10u) << "all 40 may hit something around it";
  const Hits hits({1, 8, 9, 40}, {false, false, false, false});
  EXPECT_EQ(hits.vote({10, 12, 14, 9}, options), hits.vote({50, 60, 70, 9}, options));
}

TEST(LeafVote, ALeafThatIsNotSureNeedsOthersAroundIt) {
  const VoxelMap map = row_of_leaves(4);
  EXPECT_THAT(keep_with_neighbors(map, {1, 0, 0, 0}, {0, 0, 0, 0}, 0.5), ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(keep_with_neighbors(map, {1, 0, 0, 0}, {1, 0, 0, 0}, 0.5), ElementsAre(1, 0, 0, 0));
  // Two of the three others are dynamic.
  EXPECT_THAT(keep_with_neighbors(map, {1, 1, 1, 0}, {0, 1, 1, 0}, 0.6), ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(keep_with_neighbors(map, {1, 1, 1, 0}, {0, 1, 1, 0}, 0.7), ElementsAre(0, 1, 1, 0));
}

TEST(LeafVote, SureIsWhatManyScansSeeThrough) {
  DynamicsOptions options;
  options.sure_share = 1.5;
  options.keep_share = 1.0;  // no leaf has dynamic ones alone around it here
  options.region_share = 0.0;
  const Hits hits({1, 2, 4, 4}, {false, false, false, false});
  EXPECT_THAT(hits.vote({1, 3, 5, 0}, options), ElementsAre(0, 1, 0, 0));
  EXPECT_THAT(hits.vote({2, 2, 6, 0}, options), ElementsAre(1, 0, 1, 0));
}

}  // namespace
}  // namespace cpplus
