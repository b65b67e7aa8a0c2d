#include "cpplus/simulate/simulate_district.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/simulate/district_plan.h"
#include "cpplus/simulate/district_tile.h"
#include "cpplus/simulate/district_window.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

SimulateOptions small_district() {
  SimulateOptions options;
  options.scene = "district";
  options.area_km2 = 0.01;
  options.points_million = 0.2;
  options.width = 96;
  options.height = 72;
  options.images = 3;
  options.lidar.azimuth_steps = 360;
  options.lidar.rings = 16;
  options.render.samples_per_pixel = 1;
  return options;
}

/// A district with what went to the sink.
struct Recorded {
  SimulatedWorld world;
  std::vector<PointCloud> scans;
  std::vector<SimulatedImage> images;

  size_t num_points() const {
    size_t count = 0;
    for (const PointCloud& scan : scans) count += scan.size();
    return count;
  }
};

Recorded record(const SimulateOptions& options) {
  Recorded recorded;
  recorded.world = simulate_district(options, {[&](const PointCloud& points) { recorded.scans.push_back(points); },
                                               [&](const SimulatedImage& image) { recorded.images.push_back(image); }});
  return recorded;
}

std::string message_of(const SimulateOptions& options) {
  try {
    record(options);
  } catch (const UsageError& error) {
    return error.what();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SimulateDistrict, SameSeedSameDistrictForAnyNumberOfThreads) {
  set_num_threads(1);
  const Recorded one = record(small_district());
  set_num_threads(2);
  const Recorded two = record(small_district());
  set_num_threads(0);
  ASSERT_EQ(one.scans.size(), two.scans.size());
  for (size_t i = 0; i < one.scans.size(); ++i) {
    EXPECT_EQ(one.scans[i].positions, two.scans[i].positions) << i;
    EXPECT_EQ(one.scans[i].intensities, two.scans[i].intensities) << i;
  }
  ASSERT_EQ(one.images.size(), 3u);
  ASSERT_EQ(two.images.size(), 3u);
  for (size_t i = 0; i < one.images.size(); ++i) {
    EXPECT_EQ(one.images[i].name, one.world.images[i].name);
    EXPECT_EQ(one.images[i].pixels.pixels, two.images[i].pixels.pixels) << i;
    EXPECT_EQ(one.images[i].range.pixels, two.images[i].range.pixels) << i;
    EXPECT_EQ(one.world.images[i].on_map_camera_from_map.translation,
              two.world.images[i].on_map_camera_from_map.translation);
    EXPECT_EQ(one.world.coarse[2].camera_from_map[i].translation, two.world.coarse[2].camera_from_map[i].translation);
  }
}

TEST(SimulateDistrict, HasAsManyPointsAsAskedForEvenlyAlongTheWay) {
  const Recorded recorded = record(small_district());
  const double mean = static_cast<double>(recorded.num_points()) / static_cast<double>(recorded.scans.size());
  EXPECT_NEAR(static_cast<double>(recorded.num_points()), 2e5, mean);
  ASSERT_EQ(recorded.world.scans.size(), recorded.scans.size());
  const auto& scans = recorded.world.scans;
  const double mean_step = scans.back().stamp_s / static_cast<double>(scans.size() - 1);
  for (size_t i = 1; i < scans.size(); ++i) {
    EXPECT_GT(scans[i].stamp_s - scans[i - 1].stamp_s, 0.5 * mean_step) << i;
    EXPECT_LT(scans[i].stamp_s - scans[i - 1].stamp_s, 2.0 * mean_step) << i;
  }
  // To the end of the way.
  EXPECT_GT(scans.back().stamp_s + 2.0 * mean_step, Path(recorded.world.scene.way).duration_s());
}

TEST(SimulateDistrict, PointsLieOnTheTilesWhereverTheWindowWas) {
  SimulateOptions options = small_district();
  options.points_million = 0.05;
  options.images = 1;
  options.blurred = 0;
  options.scan_pose_sigma_m = 0.0;
  options.scan_pose_sigma_deg = 0.0;
  options.lidar.range_noise_m = 0.0;
  options.lidar.divergence_mrad = 0.0;
  const Recorded recorded = record(options);
  const DistrictPlan plan = plan_district(options.area_km2, static_cast<uint64_t>(options.seed));
  const Scene surroundings = district_surroundings(plan);
  DistrictWindow window(plan, surroundings, 210.0);  // of the middle: reaches as far as any scan
  window.move_to({0.1, 0.1});
  size_t disagreeing = 0;
  for (size_t s = 0; s < recorded.scans.size(); ++s) {
    const Vector3d eye = recorded.world.scans[s].true_map_from_lidar.translation;
    for (size_t i = 0; i < recorded.scans[s].size(); ++i) {
      const Vector3d ray = recorded.scans[s].point(i) - eye;
      const auto hit = window.tracer().trace_static(eye.cast<float>(), ray.normalized().cast<float>());
      // A ray that just slips past an edge may meet something else by rounding.
      if (!hit || std::abs(hit->range - ray.norm()) > 0.01) ++disagreeing;
    }
  }
  EXPECT_LT(disagreeing, recorded.num_points() / 200);
}

TEST(SimulateDistrict, ExactScanPosesMakeTheMapPosesTheTrueOnes) {
  SimulateOptions options = small_district();
  const Recorded displaced = record(options);
  options.scan_pose_sigma_m = 0.0;
  options.scan_pose_sigma_deg = 0.0;
  const Recorded exact = record(options);
  for (size_t i = 0; i < exact.world.images.size(); ++i) {
    const auto error = [i](const Recorded& recorded) {
      const SimulatedImage& image = recorded.world.images[i];
      return camera_difference(image.camera_from_map, image.on_map_camera_from_map);
    };
    EXPECT_LT(error(exact).norm(), 1e-6);
    EXPECT_GT(error(displaced).norm(), 1e-5);
    EXPECT_LT(error(displaced).tail<3>().norm(), 0.05);
    EXPECT_LT(error(displaced).head<3>().norm(), 0.005);
  }
}

TEST(SimulateDistrict, BadOptionsAreNamed) {
  for (const double area_km2 :
       {-0.1, 0.0, 0.009, 16.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    SimulateOptions options = small_district();
    options.area_km2 = area_km2;
    EXPECT_NE(message_of(options).find("area"), std::string::npos) << area_km2;
  }
  SimulateOptions options = small_district();
  options.points_million = -1.0;
  EXPECT_NE(message_of(options).find("points"), std::string::npos);
  options = small_district();
  options.lidar.max_range_m = 300.0;
  EXPECT_NE(message_of(options).find("max_range_m"), std::string::npos);
  options = small_district();
  options.standing = true;
  EXPECT_NE(message_of(options).find("standing"), std::string::npos);
  options = small_district();
  options.scene = "street";
  EXPECT_NE(message_of(options).find("area"), std::string::npos);
}

}  // namespace
}  // namespace cpplus
