#include "cpplus/dynamics/fill_by_scan.h"

#include <gmock/gmock.h>

namespace cpplus {
namespace {

using testing::ElementsAre;

/// A row of leaves along x, a decimetre apart; each scan hits those that it is given, at most once.
struct Row {
  explicit Row(const std::vector<std::vector<int>>& leaves_of_scans) {
    for (const std::vector<int>& leaves : leaves_of_scans) {
      for (const int leaf : leaves) {
        scans.points.positions.emplace_back(0.1f * static_cast<float>(leaf) + 0.03f, 0.03f, 0.03f);
      }
      scans.first_point.push_back(scans.points.size());
      scans.sensors_in_map.emplace_back(0, 0, 0);
    }
    map = VoxelMap(scans.points, {});
    num_scans.assign(map.num_nodes(map.leaf_layer()), 0);
    for (const Eigen::Vector3f& point : scans.points.positions) ++num_scans[*map.find_leaf(point.cast<double>())];
  }

  std::vector<uint8_t> fill(const std::vector<uint8_t>& labels, double fill_share) const {
    DynamicsOptions options;
    options.fill_share = fill_share;
    return fill_by_scan(map, scans, num_scans, labels, options);
  }

  ScanSet scans;
  VoxelMap map;
  std::vector<uint32_t> num_scans;
};

TEST(FillByScan, TheRestOfWhatAScanHitsThere) {
  const Row row({{0, 1, 2, 3}});
  EXPECT_THAT(row.fill({1, 1, 0, 0}, 0.5), ElementsAre(1, 1, 1, 1));
  EXPECT_THAT(row.fill({1, 1, 0, 0}, 0.6), ElementsAre(1, 1, 0, 0)) << "a half is less than the share";
  EXPECT_THAT(row.fill({1, 0, 0, 0}, 0.25), ElementsAre(1, 0, 0, 0)) << "one dynamic leaf is too few";
}

TEST(FillByScan, OtherScansHaveNoSay) {
  const Row row({{0, 1, 2}, {3, 4}});
  EXPECT_THAT(row.fill({1, 1, 0, 0, 0}, 0.5), ElementsAre(1, 1, 1, 0, 0));
}

TEST(FillByScan, EachScanThatHitsALeafMustSaySo) {
  const Row row({{0, 1, 2}, {2, 3, 4}});
  EXPECT_THAT(row.fill({1, 1, 0, 0, 0}, 0.5), ElementsAre(1, 1, 0, 0, 0)) << "the second scan sees nothing move";
}

TEST(FillByScan, WhatFarMoreScansHitIsSomethingElse) {
  const Row row({{0, 1, 2, 3}, {3}, {3}});
  EXPECT_THAT(row.fill({1, 1, 0, 0}, 0.6), ElementsAre(1, 1, 1, 0))
      << "the last leaf, which three scans hit, is neither filled nor counted";
}

TEST(FillByScan, NotFarAway) {
  const Row row({{0, 1, 19}});  // 1.9 m: beyond the voxel beside that of half a metre
  EXPECT_THAT(row.fill({1, 1, 0}, 0.1), ElementsAre(1, 1, 0));
}

}  // namespace
}  // namespace cpplus
