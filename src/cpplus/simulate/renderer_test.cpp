#include "cpplus/simulate/renderer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/simulate/test_scene.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double to_linear(uint8_t value) {
  const double x = value / 255.0;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

/// Takes one noise-free picture of the square from the origin.
ColorImage picture(const Camera& camera, const Shot& shot) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  const SoftLight light(tracer, 0.1f);
  const Path path(scene.way);
  RenderOptions options;
  options.samples_per_pixel = 64;
  options.noise_grey = 0.0;
  options.exposure_sigma = 0.0;
  return Renderer(tracer, light, camera, path, camera_ahead(), options).render(shot);
}

/// Where a dark-bright step lies along a line of pixels, from its area: exact for a box-shaped pixel.
double step_position(const ColorImage& image, int x0, int y0, int dx, int dy, int length) {
  const double dark = to_linear(image.at(x0, y0)[1]);
  const double bright = to_linear(image.at(x0 + (length - 1) * dx, y0 + (length - 1) * dy)[1]);
  double covered = 0.0;
  for (int i = 0; i < length; ++i) {
    covered += (to_linear(image.at(x0 + i * dx, y0 + i * dy)[1]) - dark) / (bright - dark);
  }
  return length - 0.5 - covered;
}

TEST(Renderer, CornerOfTheMeshIsRenderedWhereItProjects) {
  const Camera camera(CameraModel::kPinhole, 160, 120, {100.0, 100.0, 79.3, 58.8});
  const ColorImage image = picture(camera, {});
  // The square's upper left corner as the camera sees it: y = 0.5 (left), z = 0.5 (up), 2 m ahead.
  const auto corner = camera.project(inverse(camera_ahead()) * Vector3d(2.0, 0.5, 0.5));
  ASSERT_TRUE(corner.has_value());
  EXPECT_NEAR(corner->x(), 54.3, 1e-9);
  EXPECT_NEAR(corner->y(), 33.8, 1e-9);
  const double left = 44 + step_position(image, 44, 60, 1, 0, 20);
  const double top = 24 + step_position(image, 80, 24, 0, 1, 20);
  EXPECT_NEAR(left, corner->x(), 0.1);
  EXPECT_NEAR(top, corner->y(), 0.1);
}

TEST(Renderer, FisheyeAgreesWithItsProjection) {
  const Camera camera(CameraModel::kOpenCvFisheye, 160, 120, {50.0, 50.0, 79.5, 59.5, 0.02, -0.01, 0.0, 0.0});
  const ColorImage image = picture(camera, {});
  for (const double z : {-0.3, 0.0, 0.3}) {
    // The straight edge y = 0.5 is curved here: compare it row by row.
    const auto on_edge = camera.project(inverse(camera_ahead()) * Vector3d(2.0, 0.5, z));
    ASSERT_TRUE(on_edge.has_value());
    const int row = static_cast<int>(std::lround(on_edge->y()));
    const auto bearing = camera.unproject(Vector2d(on_edge->x(), row));
    ASSERT_TRUE(bearing.has_value());
    EXPECT_NEAR(55 + step_position(image, 55, row, 1, 0, 24), on_edge->x(), 0.15) << z;
  }
}

TEST(Renderer, RangeIsTheDistanceAlongTheRay) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  const SoftLight light(tracer, 0.1f);
  const Path path(scene.way);
  const Camera camera(CameraModel::kPinhole, 160, 120, {100.0, 100.0, 79.5, 59.5});
  const Renderer renderer(tracer, light, camera, path, camera_ahead(), {});
  const RangeImage range = renderer.range({}, 4, 1.5);
  ASSERT_EQ(range.width, 40);
  ASSERT_EQ(range.height, 30);
  // Pixel (1.5, 1.5): the ray (-0.78, -0.58, 1) meets the wall 3 m ahead.
  EXPECT_NEAR(range.at(0, 0), 3.0 * Vector3d(-0.78, -0.58, 1.0).norm(), 1e-4);
  EXPECT_NEAR(range.at(20, 15), 2.0 * Vector3d(0.02, 0.02, 1.0).norm(), 1e-4);
}

TEST(Renderer, ARollingShutterReadsEachRowAtItsOwnInstant) {
  Scene scene = wall_and_square();
  // Walks sideways at 1 m/s or so: rows that are read later see the square farther to the right.
  scene.way.points.clear();
  for (int i = 0; i <= 20; ++i) scene.way.points.push_back({{0.0, 0.1 * i - 1.0}, 0.0});
  scene.way.speed_mps = 1.0;
  const Tracer tracer(scene);
  const SoftLight light(tracer, 0.1f);
  const Path path(scene.way);
  const Camera camera(CameraModel::kPinhole, 160, 120, {100.0, 100.0, 79.5, 59.5});
  RenderOptions options;
  options.samples_per_pixel = 16;
  options.noise_grey = 0.0;
  options.readout_s = 0.2;
  const Renderer renderer(tracer, light, camera, path, camera_ahead(), options);
  Shot shot;
  shot.stamp_s = 0.5 * path.duration_s();
  const ColorImage image = renderer.render(shot);
  double upper = 0.0;
  double lower = 0.0;
  for (const bool is_upper : {true, false}) {
    const auto on_edge = renderer.project(shot, {2.0, 0.5, is_upper ? 0.35 : -0.35});
    ASSERT_TRUE(on_edge.has_value());
    const int row = static_cast<int>(std::lround(on_edge->y()));
    const int start = static_cast<int>(on_edge->x()) - 10;
    EXPECT_NEAR(start + step_position(image, start, row, 1, 0, 20), on_edge->x(), 0.15);
    (is_upper ? upper : lower) = on_edge->x();
  }
  EXPECT_GT(lower - upper, 1.0);
}

TEST(Renderer, JoltBlursAlongItsDirectionOnly) {
  const Camera camera(CameraModel::kPinhole, 160, 120, {100.0, 100.0, 79.5, 59.5});
  Shot shot;
  shot.blur_px = 10.0;
  shot.blur_direction_rad = 0.0;
  const ColorImage image = picture(camera, shot);
  const auto width_of_ramp = [&](int x0, int y0, int dx, int dy) {
    const double dark = to_linear(image.at(x0, y0)[1]);
    const double bright = to_linear(image.at(x0 + 29 * dx, y0 + 29 * dy)[1]);
    int count = 0;
    for (int i = 0; i < 30; ++i) {
      const double share = (to_linear(image.at(x0 + i * dx, y0 + i * dy)[1]) - dark) / (bright - dark);
      if (share > 0.03 && share < 0.97) ++count;
    }
    return count;
  };
  EXPECT_NEAR(width_of_ramp(40, 60, 1, 0), 10, 1.5);
  EXPECT_LE(width_of_ramp(80, 20, 0, 1), 2);
}

}  // namespace
}  // namespace cpplus
