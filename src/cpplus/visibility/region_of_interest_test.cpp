#include "cpplus/visibility/region_of_interest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"
#include "cpplus/visibility/scene_test_util.h"

namespace cpplus {
namespace {

struct TwoRooms {
  VoxelMap map;
  double wall_z = 0.0;
};

/// A wall across the view at wall_z and a corridor behind it: floor, ceiling, side walls and an end wall. The camera is
/// at the origin and looks along z, as COLMAP has it (y down).
TwoRooms two_rooms(double wall_z, double spacing) {
  Random random(7);
  PointCloud cloud;
  const double w = 16.0;
  const double h = 12.0;
  add_rectangle({-w, -h, wall_z}, {2 * w, 0, 0}, {0, 2 * h, 0}, spacing, 0.01, &random, &cloud);
  const double z0 = wall_z + 0.5;
  for (const double x : {-1.0, 1.0})
    add_rectangle({x, -1.5, z0}, {0, 3, 0}, {0, 0, 4.0}, spacing, 0.01, &random, &cloud);
  for (const double y : {-1.5, 1.5}) add_rectangle({-1, y, z0}, {2, 0, 0}, {0, 0, 4.0}, spacing, 0.01, &random, &cloud);
  add_rectangle({-1, -1.5, z0 + 4.0}, {2, 0, 0}, {0, 3, 0}, spacing, 0.01, &random, &cloud);
  return {VoxelMap(cloud, VoxelMapOptions()), wall_z};
}

Camera pinhole() { return Camera(CameraModel::kPinhole, 1024, 768, {667, 667, 511.5, 383.5}); }

TEST(RegionOfInterest, TheCorridorBehindAVisibleWallIsGone) {
  for (const auto& [wall_z, spacing] : std::vector<std::pair<double, double>>{{2.0, 0.02}, {5.0, 0.03}, {15.0, 0.05}}) {
    const TwoRooms rooms = two_rooms(wall_z, spacing);
    const VisibilityResult result = find_visible_leaves(rooms.map, pinhole(), Rigid3(), VisibilityOptions());
    size_t wall_leaves = 0;
    for (const uint32_t leaf : result.leaves) {
      const double z = rooms.map.center(rooms.map.leaf_layer(), leaf).z();
      EXPECT_LT(z, wall_z + 0.3) << "wall at " << wall_z << ", leaf at "
                                 << rooms.map.center(rooms.map.leaf_layer(), leaf).transpose();
      wall_leaves += z < wall_z + 0.3;
    }
    EXPECT_GT(wall_leaves, 100u);
    EXPECT_GT(result.num_candidates, result.leaves.size() + 100u);  // the corridor was among the candidates
  }
}

TEST(RegionOfInterest, LeavesOnTheHullAreThoseOfTheWallToo) {
  const TwoRooms rooms = two_rooms(5.0, 0.03);
  VisibilityOptions options;
  options.method = "hidden_points";
  options.radius_factor = 30.0;
  options.dilation = 0;
  const VisibilityResult plain = find_visible_leaves(rooms.map, pinhole(), Rigid3(), options);
  size_t behind = 0;
  for (const uint32_t leaf : plain.leaves) behind += rooms.map.center(rooms.map.leaf_layer(), leaf).z() > 5.3;
  EXPECT_GT(plain.leaves.size(), 1000u);
  EXPECT_LT(static_cast<double>(behind), 0.01 * static_cast<double>(plain.leaves.size()));

  options.dilation = 1;
  const VisibilityResult dilated = find_visible_leaves(rooms.map, pinhole(), Rigid3(), options);
  EXPECT_GT(dilated.leaves.size(), plain.leaves.size());
  EXPECT_TRUE(std::includes(dilated.leaves.begin(), dilated.leaves.end(), plain.leaves.begin(), plain.leaves.end()));
}

TEST(RegionOfInterest, TheWideningKeepsWhatACoarsePosePutsOutside) {
  const TwoRooms rooms = two_rooms(5.0, 0.05);
  VisibilityOptions options;
  options.fov_widening_deg = 0.0;
  const auto narrow = find_visible_leaves(rooms.map, pinhole(), Rigid3(), options).leaves;
  const Rigid3 coarse(so3_exp({0, 0.03, 0}), Eigen::Vector3d::Zero());  // 1.7 deg to the side
  options.fov_widening_deg = 2.5;
  const auto wide = find_visible_leaves(rooms.map, pinhole(), coarse, options).leaves;
  std::vector<uint32_t> lost;
  std::set_difference(narrow.begin(), narrow.end(), wide.begin(), wide.end(), std::back_inserter(lost));
  EXPECT_LT(static_cast<double>(lost.size()), 0.005 * static_cast<double>(narrow.size()));
  options.fov_widening_deg = 0.0;
  const auto cut = find_visible_leaves(rooms.map, pinhole(), coarse, options).leaves;
  lost.clear();
  std::set_difference(narrow.begin(), narrow.end(), cut.begin(), cut.end(), std::back_inserter(lost));
  EXPECT_GT(static_cast<double>(lost.size()), 0.01 * static_cast<double>(narrow.size()));
}

TEST(RegionOfInterest, NothingBeyondTheDistanceNorInAnEmptyMap) {
  const TwoRooms rooms = two_rooms(5.0, 0.05);
  VisibilityOptions options;
  options.max_distance_m = 4.0;
  EXPECT_TRUE(find_visible_leaves(rooms.map, pinhole(), Rigid3(), options).leaves.empty());
  const VoxelMap empty(PointCloud(), VoxelMapOptions{});
  EXPECT_TRUE(find_visible_leaves(empty, pinhole(), Rigid3(), VisibilityOptions()).leaves.empty());
}

TEST(RegionOfInterest, RefusesBadOptions) {
  VisibilityOptions options;
  options.max_distance_m = 0.0;
  EXPECT_THROW(find_visible_leaves(VoxelMap(), pinhole(), Rigid3(), options), Error);
  options = VisibilityOptions();
  options.method = "ghpr";
  EXPECT_THROW(find_visible_leaves(VoxelMap(), pinhole(), Rigid3(), options), Error);
  options = VisibilityOptions();
  options.radius_factor = 0.3;
  EXPECT_THROW(find_visible_leaves(VoxelMap(), pinhole(), Rigid3(), options), Error);
}

}  // namespace
}  // namespace cpplus
