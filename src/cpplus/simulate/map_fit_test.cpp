#include "cpplus/simulate/map_fit.h"

#include <gtest/gtest.h>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

TEST(MapFit, AMapMovedAsAWholeMovesTheCameraWithIt) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {400.0, 400.0, 319.5, 239.5});
  const Rigid3 camera_from_truth(so3_exp({0.3, -0.2, 0.1}), {0.5, -0.4, 2.0});
  const Rigid3 map_from_truth(so3_exp({0.002, 0.001, -0.003}), {0.01, -0.02, 0.005});
  Random random(7);
  std::vector<DisplacedPoint> points;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(2, 6));
    const Eigen::Vector3d x_in_truth = inverse(camera_from_truth) * x;
    points.push_back({x_in_truth, map_from_truth * x_in_truth});
  }
  const Rigid3 fitted = fit_pose_to_map(camera, camera_from_truth, points);
  const Rigid3 expected = camera_from_truth * inverse(map_from_truth);
  EXPECT_LT(camera_difference(expected, fitted).norm(), 1e-8);
}

TEST(MapFit, APanoramaIsFittedAcrossItsSeamAndPoles) {
  const Camera camera(CameraModel::kEquirectangular, 1024, 512, {1024.0, 512.0});
  const Rigid3 camera_from_truth(so3_exp({0.1, 0.7, 0.05}), {0.5, -0.4, 0.2});
  Random random(8);
  std::vector<DisplacedPoint> points;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d bearing = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Eigen::Vector3d x_in_truth = inverse(camera_from_truth) * (random.uniform(1.5, 4.0) * bearing);
    const Eigen::Vector3d displacement(random.normal(), random.normal(), random.normal());
    points.push_back({x_in_truth, x_in_truth + Eigen::Vector3d(0.01, -0.02, 0.005) + 0.005 * displacement});
  }
  const Rigid3 fitted = fit_pose_to_map(camera, camera_from_truth, points);
  const Eigen::Vector3d moved = camera_center(fitted) - camera_center(camera_from_truth);
  EXPECT_LT((moved - Eigen::Vector3d(0.01, -0.02, 0.005)).norm(), 0.002);
  EXPECT_LT(camera_difference(camera_from_truth, fitted).head<3>().norm(), 0.001);
}

TEST(MapFit, TooFewPointsKeepTheTruePose) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {400.0, 400.0, 319.5, 239.5});
  const Rigid3 truth(so3_exp({0.3, -0.2, 0.1}), {0.5, -0.4, 2.0});
  const Rigid3 fitted = fit_pose_to_map(camera, truth, {{{0.0, 0.0, 3.0}, {0.1, 0.0, 3.0}}});
  EXPECT_LT(camera_difference(truth, fitted).norm(), 1e-14);
}

}  // namespace
}  // namespace cpplus
