#include "cpplus/simulate/lidar.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/simulate/test_scene.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

LidarOptions small_lidar() {
  LidarOptions options;
  options.rings = 16;
  options.azimuth_steps = 360;
  return options;
}

TEST(Lidar, WithoutNoiseThePointsLieOnTheSurfaces) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  LidarOptions options = small_lidar();
  options.range_noise_m = 0.0;
  options.divergence_mrad = 0.0;
  const LidarScan scan = fire_scan(tracer, {}, 0.0, 0, 1, options);
  ASSERT_GT(scan.points.size(), 500u);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const Vector3d p = scan.points.point(i);
    const bool in_square = std::abs(p.y() / p.x()) < 0.25 && std::abs(p.z() / p.x()) < 0.25;
    EXPECT_NEAR(p.x(), in_square ? 2.0 : 3.0, 1e-4 * p.norm());
  }
}

TEST(Lidar, RangeNoiseHasTheStatedSpread) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  LidarOptions options = small_lidar();
  options.divergence_mrad = 0.0;
  options.range_noise_m = 0.02;
  const LidarScan noisy = fire_scan(tracer, {}, 0.0, 0, 1, options);
  options.range_noise_m = 0.0;
  const LidarScan exact = fire_scan(tracer, {}, 0.0, 0, 1, options);
  ASSERT_EQ(noisy.points.size(), exact.points.size());
  double sum = 0.0;
  double sum_squares = 0.0;
  for (size_t i = 0; i < noisy.points.size(); ++i) {
    const double error = noisy.points.point(i).norm() - exact.points.point(i).norm();
    sum += error;
    sum_squares += error * error;
  }
  const auto n = static_cast<double>(noisy.points.size());
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(sum_squares / n), 0.02, 0.0015);
}

TEST(Lidar, BeamsThatMeetTwoSurfacesAreMixed) {
  Scene scene = wall_and_square();
  const Tracer tracer(scene);
  LidarOptions options = small_lidar();
  options.range_noise_m = 0.0;
  options.divergence_mrad = 20.0;
  options.echo_length_m = 2.0;  // the square and the wall 1 m behind it are one echo
  const auto count_between = [&] {
    const LidarScan scan = fire_scan(tracer, {}, 0.0, 0, 1, options);
    size_t count = 0;
    for (size_t i = 0; i < scan.points.size(); ++i) {
      const double x = scan.points.point(i).x();
      if (x > 2.05 && x < 2.95) ++count;
    }
    return count;
  };
  EXPECT_GT(count_between(), 5u);
  options.echo_length_m = 0.3;  // told apart: the stronger one is returned
  EXPECT_EQ(count_between(), 0u);
}

TEST(Lidar, PatternsCoverTheirFields) {
  LidarOptions options;
  options.pattern = "solid_state";
  options.beams = 20000;
  double widest = 0.0;
  for (const Vector3d& direction : beam_directions(options, 3)) {
    ASSERT_NEAR(direction.norm(), 1.0, 1e-12);
    widest = std::max(widest, std::acos(direction.x()));
  }
  EXPECT_NEAR(widest, 35.2 * M_PI / 180.0, 1e-3);
  // It does not repeat: the next scan goes elsewhere.
  const auto first = beam_directions(options, 0);
  const auto second = beam_directions(options, 1);
  double nearest = 1.0;
  for (size_t i = 80; i < 100; ++i) nearest = std::min(nearest, (first[i] - second[i]).norm());
  EXPECT_GT(nearest, 1e-3);

  options.pattern = "spinning";
  const auto rings = beam_directions(options, 0);
  EXPECT_EQ(rings.size(), 57600u);
  EXPECT_NEAR(std::asin(rings.front().z()), -M_PI / 6.0, 1e-12);
}

TEST(Lidar, SameForAnyNumberOfThreads) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  set_num_threads(1);
  const LidarScan one = fire_scan(tracer, {}, 0.0, 0, 5, small_lidar());
  set_num_threads(2);
  const LidarScan two = fire_scan(tracer, {}, 0.0, 0, 5, small_lidar());
  set_num_threads(0);
  EXPECT_EQ(one.points.positions, two.points.positions);
  EXPECT_EQ(one.points.intensities, two.points.intensities);
  EXPECT_EQ(one.labels, two.labels);
}

TEST(Lidar, BadOptionsAreNamed) {
  LidarOptions options;
  options.rings = 0;
  EXPECT_THROW(options.validate(), UsageError);
  options = {};
  options.pattern = "flash";
  EXPECT_THROW(options.validate(), UsageError);
}

}  // namespace
}  // namespace cpplus
