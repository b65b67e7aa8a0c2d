#include "cpplus/visibility/region_of_interest.h"

#include <gtest/gtest.h>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

/// Adds a rectangle corner + s * u + t * v, s and t in [0, 1], as points about `spacing` metres apart.
void add_rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v, double spacing,
                   double noise_m, Random* random, PointCloud* cloud) {
  const Eigen::Vector3d normal = u.cross(v).normalized();
  const int nu = static_cast<int>(u.norm() / spacing);
  const int nv = static_cast<int>(v.norm() / spacing);
  for (int i = 0; i <= nu; ++i) {
    for (int j = 0; j <= nv; ++j) {
      const double s = (i + random->uniform(-0.3, 0.3)) / nu;
      const double t = (j + random->uniform(-0.3, 0.3)) / nv;
      const Eigen::Vector3d x = corner + s * u + t * v + noise_m * random->normal() * normal;
      cloud->positions.push_back(x.cast<float>());
    }
  }
}

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
      EXPECT_LT(z, wall_z + 0.3) << "wall at " << wall_z;
      wall_leaves += z < wall_z + 0.3;
    }
    EXPECT_GT(wall_leaves, 100u);
    EXPECT_GT(result.num_candidates, result.leaves.size() + 100u);  // the corridor was among the candidates
  }
}

TEST(RegionOfInterest, RefusesBadOptions) {
  VisibilityOptions options;
  options.max_distance_m = 0.0;
  EXPECT_THROW(find_visible_leaves(VoxelMap(), pinhole(), Rigid3(), options), Error);
}

}  // namespace
}  // namespace cpplus
