#include "cpplus/evaluate/reprojection_shift.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

const Camera kCamera(CameraModel::kPinhole, 640, 480, {500.0, 400.0, 320.0, 240.0});
const Rigid3 kIdentity;

TEST(ReprojectionShift, OfASidewaysStepByHand) {
  // The camera moves 0.1 m to the right: points at 2 m and 10 m move left by 500 * 0.1 / depth = 25 and 5 px.
  const Rigid3 estimate{Eigen::Quaterniond::Identity(), Eigen::Vector3d(-0.1, 0, 0)};
  const ReprojectionShift shift = reprojection_shift({{0, 0, 2}, {1, -1, 10}}, kCamera, estimate, kIdentity);
  EXPECT_EQ(shift.num_points, 2u);
  EXPECT_EQ(shift.num_lost, 0u);
  EXPECT_NEAR(shift.mean_px, 15.0, 1e-9);
  EXPECT_NEAR(shift.median_px, 15.0, 1e-9);
  EXPECT_NEAR(shift.max_px, 25.0, 1e-9);
}

TEST(ReprojectionShift, IsZeroForTheSamePose) {
  EXPECT_DOUBLE_EQ(reprojection_shift({{0.3, 0, 2}}, kCamera, kIdentity, kIdentity).mean_px, 0.0);
}

TEST(ReprojectionShift, PointsBehindTheEstimateCountAsTheImageDiagonal) {
  const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY())), Eigen::Vector3d::Zero()};
  const ReprojectionShift shift = reprojection_shift({{0, 0, 2}, {0.1, 0, 3}}, kCamera, turned, kIdentity);
  EXPECT_EQ(shift.num_lost, 2u);
  EXPECT_DOUBLE_EQ(shift.mean_px, 800.0);
}

TEST(ReprojectionShift, AProjectedPointIsCappedAtTheDiagonalToo) {
  // 3 m to the side at 1 m depth would be 1500 px.
  const Rigid3 estimate{Eigen::Quaterniond::Identity(), Eigen::Vector3d(3, 0, 0)};
  const ReprojectionShift shift = reprojection_shift({{0, 0, 1}}, kCamera, estimate, kIdentity);
  EXPECT_EQ(shift.num_lost, 0u);
  EXPECT_DOUBLE_EQ(shift.mean_px, 800.0);
}

TEST(ReprojectionShift, PointsThatTheReferenceDoesNotSeeAreLeftOut) {
  const ReprojectionShift shift = reprojection_shift({{0, 0, -2}}, kCamera, kIdentity, kIdentity);
  EXPECT_EQ(shift.num_points, 0u);
  EXPECT_TRUE(std::isnan(shift.mean_px));
}

TEST(ReprojectionShift, OfAPanoramaGoesAcrossTheSeam) {
  // 360 px = 360 degrees; the point is straight behind, one degree either side of the seam.
  const Camera panorama(CameraModel::kEquirectangular, 360, 180, {360.0, 180.0});
  const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(2 * M_PI / 180, Eigen::Vector3d::UnitY())),
                      Eigen::Vector3d::Zero()};
  const Eigen::Vector3d point(std::sin(M_PI - M_PI / 180), 0, std::cos(M_PI - M_PI / 180));
  EXPECT_NEAR(reprojection_shift({point}, panorama, turned, kIdentity).mean_px, 2.0, 1e-6);
}

TEST(VisiblePointsFromRanges, AreAtTheRangeAlongTheRayNotAtTheDepth) {
  RangeGrid grid{
      RangeImage(2, 1), 375.0, {320.0, 320.0}};  // pixels (320, 320) and (695, 320): off the centre by 0 and 375
  grid.ranges.at(0, 0) = 0.0f;                   // nothing there
  grid.ranges.at(1, 0) = 2.0f;
  const Camera camera(CameraModel::kPinhole, 1000, 640, {500.0, 500.0, 320.0, 320.0});
  const Rigid3 camera_from_map{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -10)};  // centre at z = 10
  const auto points = visible_points_from_ranges(grid, camera, camera_from_map);
  ASSERT_EQ(points.size(), 1u);
  // Bearing (375, 0, 500) / 625 = (0.6, 0, 0.8), 2 m away.
  EXPECT_TRUE(points[0].isApprox(Eigen::Vector3d(1.2, 0, 11.6), 1e-9)) << points[0].transpose();
}

TEST(VisiblePointsFromRanges, ProjectBackToTheirPixels) {
  RangeGrid grid{RangeImage(5, 4, 3.0f), 4.0, {1.5, 1.5}};
  const Camera camera(CameraModel::kOpenCv, 20, 16, {15.0, 15.5, 9.8, 7.9, -0.1, 0.03, 0.001, -0.0005});
  const Rigid3 camera_from_map{Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2), Eigen::Vector3d(1, -2, 3)};
  const auto points = visible_points_from_ranges(grid, camera, camera_from_map);
  ASSERT_EQ(points.size(), 20u);
  const auto pixel = camera.project(camera_from_map * points[5 * 2 + 3]);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 13.5, 1e-6);
  EXPECT_NEAR(pixel->y(), 9.5, 1e-6);
}

}  // namespace
}  // namespace cpplus
