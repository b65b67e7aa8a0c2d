#include "cpplus/simulate/map_displacement.h"

#include <gtest/gtest.h>

#include "cpplus/simulate/lidar.h"
#include "cpplus/simulate/test_scene.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr double kReach = 10.0;

/// Before the wall, at a stamp, with the map displaced.
SimulatedScan scan_at(const Tracer& tracer, double stamp_s, const Rigid3& map_from_truth) {
  LidarOptions lidar;
  lidar.rings = 24;
  lidar.azimuth_steps = 360;
  lidar.range_noise_m = 0.0;
  lidar.divergence_mrad = 0.0;
  SimulatedScan scan;
  scan.stamp_s = stamp_s;
  scan.true_map_from_lidar.translation = {0.0, 0.1, -0.2};
  scan.map_from_lidar = map_from_truth * scan.true_map_from_lidar;
  scan.scan = fire_scan(tracer, scan.true_map_from_lidar, stamp_s, 0, 1, lidar);
  return scan;
}

TEST(MapDisplacement, ImagesFollowTheMapOfTheScansAroundThem) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  const Camera camera(CameraModel::kPinhole, 320, 240, {200.0, 200.0, 159.5, 119.5});
  std::vector<SimulatedImage> images(3);
  for (size_t i = 0; i < images.size(); ++i) {
    images[i].stamp_s = 100.0 * static_cast<double>(i);
    images[i].camera_from_map = inverse(camera_ahead());
  }
  const Rigid3 first(Eigen::Quaterniond(so3_exp({0.002, -0.001, 0.003})), {0.01, -0.02, 0.005});
  const Rigid3 second(Eigen::Quaterniond(so3_exp({-0.001, 0.002, 0.001})), {-0.01, 0.01, 0.01});
  MapDisplacement displacement(camera, images, kReach);
  displacement.add(scan_at(tracer, 95.0, first), tracer);
  displacement.add(scan_at(tracer, 105.0, first), tracer);
  displacement.add(scan_at(tracer, 150.0, second), tracer);  // near no image
  displacement.add(scan_at(tracer, 201.0, second), tracer);
  const std::vector<Rigid3> fitted = displacement.finish();
  ASSERT_EQ(fitted.size(), 3u);
  const auto error = [&](size_t image, const Rigid3& map_from_truth) {
    return camera_difference(fitted[image], images[image].camera_from_map * inverse(map_from_truth)).norm();
  };
  // Of a map that a rigid transform has displaced as a whole: float positions leave some micrometres.
  EXPECT_LT(error(0, Rigid3()), 1e-12);  // no scan is near: as in truth
  EXPECT_LT(error(1, first), 2e-5);
  EXPECT_LT(error(2, second), 2e-5);
}

TEST(MapDisplacement, ScansThatFollowCloselyArePassedOver) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  const Camera camera(CameraModel::kPinhole, 320, 240, {200.0, 200.0, 159.5, 119.5});
  std::vector<SimulatedImage> images(1);
  images[0].camera_from_map = inverse(camera_ahead());
  const Rigid3 displaced(Eigen::Quaterniond::Identity(), Vector3d(0.0, 0.05, 0.0));
  MapDisplacement displacement(camera, images, kReach);
  displacement.add(scan_at(tracer, 0.0, Rigid3()), tracer);
  displacement.add(scan_at(tracer, 0.01, displaced), tracer);
  EXPECT_LT(camera_difference(displacement.finish()[0], images[0].camera_from_map).norm(), 2e-5);
}

}  // namespace
}  // namespace cpplus
