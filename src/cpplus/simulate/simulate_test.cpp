#include "cpplus/simulate/simulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

SimulateOptions small(const std::string& scene) {
  SimulateOptions options;
  options.scene = scene;
  options.width = 128;
  options.height = 96;
  options.images = 3;
  options.blurred = 1;
  options.scans = 4;
  options.lidar.azimuth_steps = 360;
  options.lidar.rings = 16;
  options.render.samples_per_pixel = 1;
  return options;
}

bool same_pose(const Rigid3& a, const Rigid3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

void expect_same(const SimulatedWorld& a, const SimulatedWorld& b) {
  ASSERT_EQ(a.images.size(), b.images.size());
  for (size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].pixels.pixels, b.images[i].pixels.pixels) << i;
    EXPECT_EQ(a.images[i].range.pixels, b.images[i].range.pixels) << i;
    EXPECT_TRUE(same_pose(a.images[i].camera_from_map, b.images[i].camera_from_map)) << i;
    EXPECT_TRUE(same_pose(a.images[i].on_map_camera_from_map, b.images[i].on_map_camera_from_map)) << i;
  }
  EXPECT_EQ(a.map.positions, b.map.positions);
  EXPECT_EQ(a.map.intensities, b.map.intensities);
  EXPECT_EQ(a.map_labels, b.map_labels);
  ASSERT_EQ(a.coarse.size(), b.coarse.size());
  for (size_t i = 0; i < a.coarse.size(); ++i) {
    for (size_t k = 0; k < a.images.size(); ++k) {
      EXPECT_TRUE(same_pose(a.coarse[i].camera_from_map[k], b.coarse[i].camera_from_map[k]));
    }
  }
}

TEST(SimulateWorld, SameSeedSameWorldForAnyNumberOfThreads) {
  set_num_threads(1);
  const SimulatedWorld one = simulate_world(small("room"));
  set_num_threads(2);
  const SimulatedWorld two = simulate_world(small("room"));
  set_num_threads(0);
  expect_same(one, two);
}

TEST(SimulateWorld, LabelsMarkTheReturnsOfMovingBodies) {
  SimulateOptions options = small("hall");
  options.lidar.divergence_mrad = 0.0;
  options.lidar.range_noise_m = 0.0;
  options.scans = 6;
  const SimulatedWorld world = simulate_world(options);
  ASSERT_FALSE(world.scene.bodies.empty());
  const Tracer tracer(world.scene);
  size_t moving = 0;
  size_t disagreeing = 0;
  for (const SimulatedScan& scan : world.scans) {
    const BodyPoses bodies = body_poses(world.scene, scan.stamp_s);
    const Vector3d origin = scan.true_map_from_lidar.translation;
    for (size_t i = 0; i < scan.scan.points.size(); ++i) {
      const Vector3d ray = (scan.true_map_from_lidar * scan.scan.points.point(i) - origin).normalized();
      const auto hit = tracer.trace(origin.cast<float>(), ray.cast<float>(), bodies);
      const auto behind = tracer.trace_static(origin.cast<float>(), ray.cast<float>());
      if (!hit || (hit->body >= 0) != (scan.scan.labels[i] == 1)) {
        ++disagreeing;  // a ray that grazes a silhouette may fall on the other side by rounding
        continue;
      }
      if (scan.scan.labels[i] == 1) {
        ++moving;
        ASSERT_TRUE(!behind || behind->range > scan.scan.points.point(i).norm() - 1e-3);
      }
    }
  }
  EXPECT_GT(moving, 20u);
  EXPECT_LT(disagreeing, 5u);
  const auto labelled = static_cast<size_t>(std::count(world.map_labels.begin(), world.map_labels.end(), 1));
  EXPECT_GT(labelled, 10u);
  EXPECT_LT(labelled, world.map.size() / 5);

  options.moving = false;
  const SimulatedWorld still = simulate_world(options);
  EXPECT_EQ(std::count(still.map_labels.begin(), still.map_labels.end(), 1), 0);
}

TEST(SimulateWorld, AStandingSolidStateLidarCoversWhatTheImagesSee) {
  SimulateOptions options = small("room");
  options.standing = true;
  options.lidar.pattern = "solid_state";
  options.lidar.beams = 20000;
  const SimulatedWorld world = simulate_world(options);
  for (const SimulatedScan& scan : world.scans) {
    EXPECT_EQ(scan.true_map_from_lidar.translation, world.scans[0].true_map_from_lidar.translation);
  }
  for (const SimulatedImage& image : world.images) {
    size_t inside = 0;
    for (size_t i = 0; i < world.map.size(); ++i) {
      const auto pixel = world.camera.project(image.camera_from_map * world.map.point(i));
      if (pixel && world.camera.in_image(*pixel)) ++inside;
    }
    EXPECT_GT(inside, world.map.size() / 3);
  }
}

TEST(SimulateWorld, BoardViewsAreWhereTheMeshIsSeen) {
  SimulateOptions options = small("room");
  options.width = 640;
  options.height = 480;
  options.images = 6;
  options.blurred = 0;
  const SimulatedWorld world = simulate_world(options);
  ASSERT_EQ(world.scene.boards.size(), 3u);
  ASSERT_FALSE(world.board_views.empty());
  for (const BoardView& view : world.board_views) {
    const SimulatedImage& image = world.images[view.image];
    const SceneCheckerboard& board = world.scene.boards[view.board];
    ASSERT_EQ(view.corners_px.size(), board.corners.size());
    const auto first = world.camera.project(image.camera_from_map * board.corners[0]);
    ASSERT_TRUE(first.has_value());
    EXPECT_LT((*first - view.corners_px[0]).norm(), 1e-9);
    // The four squares around an inner corner: two dark, two bright, crosswise.
    const size_t i = 1 + static_cast<size_t>(board.inner_columns);
    const Eigen::Vector2d right = 0.5 * (view.corners_px[i + 1] - view.corners_px[i]);
    const Eigen::Vector2d down =
        0.5 * (view.corners_px[i + static_cast<size_t>(board.inner_columns)] - view.corners_px[i]);
    if (view.min_spacing_px < 6.0) continue;
    const auto grey = [&](double a, double b) {
      const Eigen::Vector2d p = view.corners_px[i] + a * right + b * down;
      return static_cast<int>(
          image.pixels.at(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())))[1]);
    };
    const int contrast = (grey(1, 1) + grey(-1, -1)) - (grey(1, -1) + grey(-1, 1));
    EXPECT_GT(std::abs(contrast), 80);
  }
}

TEST(SimulateWorld, AnotherSeedIsAnotherWorld) {
  SimulateOptions options = small("room");
  const SimulatedWorld one = simulate_world(options);
  options.seed = 2;
  const SimulatedWorld two = simulate_world(options);
  EXPECT_NE(one.images[0].pixels.pixels, two.images[0].pixels.pixels);
  EXPECT_NE(one.scene.mesh.faces.size(), two.scene.mesh.faces.size());
}

TEST(SimulateWorld, MapPointsLieOnTheMeshWithinNoise) {
  SimulateOptions options = small("room");
  options.lidar.divergence_mrad = 0.0;
  const SimulatedWorld world = simulate_world(options);
  const Tracer tracer(world.scene);
  double sum_squares = 0.0;
  size_t count = 0;
  for (const SimulatedScan& scan : world.scans) {
    for (size_t i = 0; i < scan.scan.points.size(); ++i) {
      const Vector3d ray = scan.true_map_from_lidar * scan.scan.points.point(i) - scan.true_map_from_lidar.translation;
      const auto hit =
          tracer.trace_static(scan.true_map_from_lidar.translation.cast<float>(), ray.normalized().cast<float>());
      if (!hit || std::abs(hit->range - ray.norm()) > 0.12) continue;  // a ray that just slips past an edge
      sum_squares += std::pow(hit->range - ray.norm(), 2);
      ++count;
    }
  }
  size_t total = 0;
  for (const SimulatedScan& scan : world.scans) total += scan.scan.points.size();
  EXPECT_GT(count, total * 995 / 1000);
  EXPECT_NEAR(std::sqrt(sum_squares / static_cast<double>(count)), 0.02, 0.001);
}

TEST(SimulateWorld, TheRangeImageAgreesWithThePose) {
  const SimulatedWorld world = simulate_world(small("room"));
  const Tracer tracer(world.scene);
  const SimulatedImage& image = world.images[1];
  const Rigid3 map_from_camera = inverse(image.camera_from_map);
  for (int y = 2; y < image.range.height; y += 7) {
    for (int x = 2; x < image.range.width; x += 7) {
      const auto bearing = world.camera.unproject({4 * x + 1.5, 4 * y + 1.5});
      ASSERT_TRUE(bearing.has_value());
      const Vector3d direction = map_from_camera.rotation * *bearing;
      const auto hit = tracer.trace_static(map_from_camera.translation.cast<float>(), direction.cast<float>());
      ASSERT_EQ(hit.has_value(), image.range.at(x, y) > 0.0f);
      if (!hit) continue;
      EXPECT_NEAR(hit->range, image.range.at(x, y), 0.01f * hit->range);
    }
  }
}

TEST(SimulateWorld, ExactScanPosesMakeTheMapPosesTheTrueOnes) {
  SimulateOptions options = small("room");
  options.scan_pose_sigma_m = 0.0;
  options.scan_pose_sigma_deg = 0.0;
  const SimulatedWorld world = simulate_world(options);
  for (const SimulatedImage& image : world.images) {
    EXPECT_LT(camera_difference(image.camera_from_map, image.on_map_camera_from_map).norm(), 1e-6);
  }
  options = small("room");
  const SimulatedWorld displaced = simulate_world(options);
  for (const SimulatedImage& image : displaced.images) {
    const Vector6d delta = camera_difference(image.camera_from_map, image.on_map_camera_from_map);
    EXPECT_GT(delta.norm(), 1e-5);
    EXPECT_LT(delta.tail<3>().norm(), 0.05);
    EXPECT_LT(delta.head<3>().norm(), 0.005);
  }
}

TEST(SimulateWorld, BlurredImagesAreThoseWithABlurAndLoseTheirDetail) {
  SimulateOptions options = small("room");
  options.width = 320;
  options.height = 240;
  options.images = 2;
  options.blurred = 0;
  options.render.noise_grey = 0.0;
  const SimulatedWorld sharp = simulate_world(options);
  options.blurred = 2;
  const SimulatedWorld blurred = simulate_world(options);
  const auto detail = [](const ColorImage& image) {
    double sum = 0.0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 1; x + 1 < image.width; ++x) {
        const int second = image.at(x - 1, y)[1] - 2 * image.at(x, y)[1] + image.at(x + 1, y)[1];
        sum += second * second;
      }
    }
    return sum;
  };
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(sharp.images[i].blur_px, 0.0);
    EXPECT_GT(blurred.images[i].blur_px, 3.0);
    EXPECT_LT(detail(blurred.images[i].pixels), 0.35 * detail(sharp.images[i].pixels));
  }
}

TEST(SimulateWorld, BadOptionsAreNamed) {
  SimulateOptions options = small("moon");
  EXPECT_THROW(simulate_world(options), UsageError);
  options = small("room");
  options.camera = "SIMPLE_RADIAL";
  EXPECT_THROW(simulate_world(options), UsageError);
  options = small("room");
  options.blurred = 9;
  EXPECT_THROW(simulate_world(options), UsageError);
}

}  // namespace
}  // namespace cpplus
