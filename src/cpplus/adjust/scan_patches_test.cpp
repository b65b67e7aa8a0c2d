#include "cpplus/adjust/scan_patches.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// Scans of pieces of walls, each with points of its own.
struct Walls {
  PointCloud points;
  std::vector<uint32_t> scan_of_point;
  std::vector<Vector3d> sensors;
  Random random{5};

  /// 4 m by 4 m about the origin at x, 3000 points, 1 cm of noise.
  void add_wall(double x, uint32_t scan, double noise_m = 0.01) {
    for (int i = 0; i < 3000; ++i) {
      const Vector3d point(x + noise_m * random.normal(), random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0));
      points.positions.push_back((point - points.origin).cast<float>());
      scan_of_point.push_back(scan);
    }
  }

  std::vector<ScanPatch> patches(const PatchOptions& options = {}) const {
    return find_scan_patches(points, scan_of_point, sensors, options);
  }
};

TEST(ScanPatches, OfOneWallLieOnItWithAllScans) {
  Walls walls;
  for (uint32_t scan = 0; scan < 4; ++scan) {
    walls.sensors.emplace_back(-5.0, scan, 0.0);
    walls.add_wall(0.0, scan);
  }
  const std::vector<ScanPatch> patches = walls.patches();
  ASSERT_GE(patches.size(), 3u);
  double num_points = 0.0;
  for (const ScanPatch& patch : patches) {
    EXPECT_GT(std::abs(patch.normal.x()), 0.995);
    for (const ScanCluster& cluster : patch.clusters) {
      EXPECT_NEAR(cluster.mean.x(), 0.0, 0.01);
      num_points += cluster.count;
    }
  }
  EXPECT_GT(num_points, 0.95 * 12000.0);
  EXPECT_NEAR(range_noise(patches), 0.01, 0.001);
}

TEST(ScanPatches, TheTwoFacesOfAThinWallAreTwoPatches) {
  Walls walls;
  for (uint32_t scan = 0; scan < 6; ++scan) {
    const double side = scan % 2 == 0 ? 1.0 : -1.0;
    walls.sensors.emplace_back(5.0 * side, 0.0, 0.0);
    walls.add_wall(0.05 * side, scan);
  }
  const std::vector<ScanPatch> patches = walls.patches();
  ASSERT_GE(patches.size(), 4u);
  for (const ScanPatch& patch : patches) {
    ASSERT_EQ(patch.clusters.size(), 3u);
    const double side = patch.clusters[0].scan % 2 == 0 ? 1.0 : -1.0;
    for (const ScanCluster& cluster : patch.clusters) EXPECT_NEAR(cluster.mean.x(), 0.05 * side, 0.02);
  }
}

TEST(ScanPatches, NeedPlanesThatEnoughScansSee) {
  Walls two_scans;
  for (uint32_t scan = 0; scan < 2; ++scan) {
    two_scans.sensors.emplace_back(-5.0, 0.0, 0.0);
    two_scans.add_wall(0.0, scan);
  }
  EXPECT_TRUE(two_scans.patches().empty());
  PatchOptions two;
  two.min_scans = 2;
  EXPECT_FALSE(two_scans.patches(two).empty());
  Walls cloud;  // as thick as a hedge
  for (uint32_t scan = 0; scan < 4; ++scan) {
    cloud.sensors.emplace_back(-5.0, 0.0, 0.0);
    cloud.add_wall(0.0, scan, 0.4);
  }
  EXPECT_TRUE(cloud.patches().empty());
}

TEST(ScanPatches, AreTheSameFarFromTheOrigin) {
  std::vector<std::vector<ScanPatch>> patches;
  const Vector3d far(691234.0, 5334567.0, 510.0);
  for (const Vector3d& origin : {Vector3d(0, 0, 0), far}) {
    Walls walls;
    for (uint32_t scan = 0; scan < 3; ++scan) {
      walls.sensors.emplace_back(-5.0, 0.0, 0.0);
      walls.add_wall(0.0, scan);
      walls.sensors.back() += origin;
    }
    walls.points.origin = origin;
    patches.push_back(walls.patches());
  }
  ASSERT_EQ(patches[0].size(), patches[1].size());
  for (size_t i = 0; i < patches[0].size(); ++i) {
    const Vector3d shift = patches[1][i].clusters[0].mean - patches[0][i].clusters[0].mean;
    EXPECT_LT((shift - far).norm(), 1e-6);
  }
}

TEST(PatchOptions, RefuseVoxelsThatDoNotNest) {
  PatchOptions options;
  options.smallest_m = 0.3;
  EXPECT_ANY_THROW(options.validate());
}

}  // namespace
}  // namespace cpplus
