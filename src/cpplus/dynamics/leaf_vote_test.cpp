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
    return vote_on_leaves(*map, scans, surfaces, num_through, options);
  }
};

DynamicsOptions alone() {
  DynamicsOptions options;
  options.keep_share = 0.0;
  options.fill_share = 1.0;
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
  EXPECT_THAT(Hits({1, 1, 8, 1}, {false, false, true, false}).vote({1, 0, 0, 2}, options), ElementsAre(1, 1, 0, 1))
      << "a plane is no part of what stands or moves there; the second leaf is filled";
}

TEST(RegionHits, CountsScansOnceAndOnlyWhereAskedFor) {
  const Hits hits({3, 5, 2, 4}, {false, false, true, false});
  EXPECT_THAT(count_region_hits(*hits.map, hits.scans, hits.surfaces, {1, 0, 0, 1}), ElementsAre(5, 0, 0, 5));
}

TEST(LeafVote, MoreThanSufficientScansChangeNothing) {
  DynamicsOptions options;
  options.sure_scans = 2;
  options.min_share = 0.25;
  options.region_share = 0.25;
  EXPECT_EQ(sufficient_scans(1, 8, options), 2u);
  EXPECT_EQ(sufficient_scans(9, 9, options), 3u);
  EXPECT_EQ(sufficient_scans(1, 40, options), 10u) << "all 40 may hit something around it";
  const Hits hits({1, 8, 9, 40}, {false, false, false, false});
  EXPECT_EQ(hits.vote({10, 10, 10, 9}, options), hits.vote({50, 60, 70, 9}, options));
}

TEST(LeafVote, ALeafAmongDynamicOnesIsFilled) {
  const VoxelMap map = row_of_leaves(4);
  DynamicsOptions options;
  options.fill_share = 0.6;
  EXPECT_THAT(vote_with_neighbors(map, {1, 0, 1, 1}, {1, 1, 1, 1}, {5, 0, 5, 5}, options), ElementsAre(1, 1, 1, 1));
  // One of three around each of the others: too few.
  EXPECT_THAT(vote_with_neighbors(map, {1, 0, 0, 0}, {1, 1, 1, 1}, {5, 0, 0, 0}, options), ElementsAre(1, 0, 0, 0));
}

TEST(LeafVote, WhatFarMoreScansHitHasNoSayInFilling) {
  const VoxelMap map = row_of_leaves(4);
  DynamicsOptions options;
  options.fill_share = 0.7;
  EXPECT_THAT(vote_with_neighbors(map, {1, 0, 1, 0}, {1, 1, 1, 8}, {5, 0, 5, 0}, options), ElementsAre(1, 1, 1, 0))
      << "the second leaf is filled whatever the fourth is, and the fourth, with two of three, is not";
  EXPECT_THAT(vote_with_neighbors(map, {1, 0, 0, 0}, {1, 1, 8, 8}, {5, 0, 0, 0}, options), ElementsAre(1, 0, 0, 0))
      << "one voter is too few";
}

TEST(LeafVote, ALonelyUnsureLeafIsStatic) {
  const VoxelMap map = row_of_leaves(4);
  DynamicsOptions options;
  options.sure_scans = 2;
  options.fill_share = 1.0;
  EXPECT_THAT(vote_with_neighbors(map, {1, 0, 0, 0}, {1, 1, 1, 1}, {1, 0, 0, 0}, options), ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(vote_with_neighbors(map, {1, 0, 0, 0}, {1, 1, 1, 1}, {2, 0, 0, 0}, options), ElementsAre(1, 0, 0, 0));
  EXPECT_THAT(vote_with_neighbors(map, {1, 1, 0, 0}, {1, 1, 1, 1}, {1, 2, 0, 0}, options), ElementsAre(1, 1, 0, 0));
}

}  // namespace
}  // namespace cpplus
