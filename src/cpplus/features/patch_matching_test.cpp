#include "cpplus/features/patch_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

// A surface in front of the cameras: the part x > x_from of the plane z = depth, seen from below. Its brightness is a
// sum of waves from 4 to 40 cm long.
struct Wall {
  double depth = 3.0;
  double x_from = -1e9;
  uint64_t seed = 1;
  double contrast = 1.0;
};

class Texture {
 public:
  explicit Texture(const Wall& wall) : contrast_(wall.contrast) {
    Random random(wall.seed);
    for (int k = 0; k < kWaves; ++k) {
      const double length = 0.04 * std::pow(10.0, random.uniform());
      const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
      waves_[k] = Eigen::Vector3d(std::cos(angle), std::sin(angle), random.uniform()) * 2.0 * std::numbers::pi;
      waves_[k].head<2>() /= length;
    }
  }

  double at(double x, double y) const {
    double sum = 0.0;
    for (const Eigen::Vector3d& wave : waves_) sum += std::cos(wave.x() * x + wave.y() * y + wave.z());
    return 128.0 + contrast_ * 14.0 * sum;
  }

 private:
  static constexpr int kWaves = 20;
  Eigen::Vector3d waves_[kWaves];
  double contrast_;
};

struct Scene {
  std::vector<Wall> walls;
  std::vector<MapPlane> planes;  // of the walls

  explicit Scene(const std::vector<Wall>& its_walls) : walls(its_walls) {
    for (const Wall& wall : walls) {
      MapPlane plane;
      plane.normal = {0, 0, -1};
      plane.centroid = {0.3, -0.2, wall.depth};
      planes.push_back(plane);
    }
  }

  // The wall that a ray meets first, and where.
  std::pair<int32_t, Eigen::Vector3d> cast(const Rigid3& camera_from_map, const Eigen::Vector3d& bearing) const {
    const Eigen::Vector3d center = camera_center(camera_from_map);
    const Eigen::Vector3d direction = camera_from_map.rotation.conjugate() * bearing;
    std::pair<int32_t, Eigen::Vector3d> hit{PlaneBuffer::kNone, Eigen::Vector3d::Zero()};
    double nearest = 1e9;
    for (size_t i = 0; i < walls.size(); ++i) {
      const double range = (walls[i].depth - center.z()) / direction.z();
      const Eigen::Vector3d x = center + range * direction;
      if (!(range > 0) || range >= nearest || x.x() < walls[i].x_from) continue;
      nearest = range;
      hit = {static_cast<int32_t>(i), x};
    }
    return hit;
  }

  PlaneBuffer plane_buffer(const Camera& camera, const Rigid3& camera_from_map) const {
    PlaneBuffer buffer;
    buffer.camera = camera;
    buffer.camera_from_map = camera_from_map;
    buffer.planes = &planes;
    buffer.plane = Image<int32_t>(camera.width() / 4, camera.height() / 4, PlaneBuffer::kNone);
    for (int y = 0; y < buffer.plane.height; ++y) {
      for (int x = 0; x < buffer.plane.width; ++x) {
        const auto bearing = camera.unproject({4 * x + 1.5, 4 * y + 1.5});
        if (bearing) buffer.plane.at(x, y) = cast(camera_from_map, *bearing).first;
      }
    }
    return buffer;
  }

  GrayImage photograph(const Camera& camera, const Rigid3& camera_from_map, double gain = 1.0,
                       double offset = 0.0) const {
    std::vector<Texture> textures(walls.begin(), walls.end());
    GrayImage image(camera.width(), camera.height());
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const auto bearing = camera.unproject({static_cast<double>(x), static_cast<double>(y)});
        if (!bearing) continue;
        const auto [wall, point] = cast(camera_from_map, *bearing);
        if (wall == PlaneBuffer::kNone) continue;
        const double value = gain * textures[static_cast<size_t>(wall)].at(point.x(), point.y()) + offset;
        image.at(x, y) = static_cast<uint8_t>(std::clamp(std::lround(value), 0l, 255l));
      }
    }
    return image;
  }
};

Camera pinhole() { return Camera(CameraModel::kPinhole, 400, 300, {300, 300, 200, 150}); }
Camera fisheye() {
  return Camera(CameraModel::kOpenCvFisheye, 400, 300, {160, 160, 200, 150, 0.02, -0.01, 0.002, -0.0005});
}

Rigid3 view_a() { return Rigid3(Eigen::Quaterniond(so3_exp({0.05, -0.1, 0.02})), Eigen::Vector3d(0.1, 0.0, 0.2)); }
Rigid3 view_b() {
  Vector6d delta;
  delta << 0.06, -0.08, 0.15, 0.5, -0.2, 0.35;
  return perturb_camera(view_a(), delta);
}
Rigid3 turned_by(const Rigid3& pose, double angle) {
  return perturb_camera(pose, angle * (Vector6d() << 0.6, -0.8, 0, 0, 0, 0).finished());
}

struct Pair {
  PatchView a, b;
  std::vector<SurfaceMatch> matches;
};

struct Shot {
  Rigid3 supposed = view_b();  // pose that the matching is told
  double gain = 1.0;
  double offset = 0.0;
};

// The true poses are view_a() and view_b(); that of b may be told wrongly.
Pair match_views(const Scene& scene, const Camera& camera, const Shot& shot = {}) {
  const PatchMatchingOptions options;
  Pair pair;
  pair.a = prepare_patch_view(scene.photograph(camera, view_a()), scene.plane_buffer(camera, view_a()), {}, options);
  pair.b = prepare_patch_view(scene.photograph(camera, view_b(), shot.gain, shot.offset),
                              scene.plane_buffer(camera, shot.supposed), {}, options);
  pair.matches = match_patches(pair.a, pair.b, options);
  return pair;
}

// Distances from where the spot is truly seen in b, ascending, pixels.
std::vector<double> errors_px(const Scene& scene, const Camera& camera, const std::vector<SurfaceMatch>& matches) {
  std::vector<double> errors;
  for (const SurfaceMatch& m : matches) {
    const auto [wall, x] = scene.cast(view_a(), *camera.unproject(m.pixel_a));
    EXPECT_EQ(wall, m.plane);
    errors.push_back((*camera.project(view_b() * x) - m.pixel_b).norm());
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

void expect_precise(const Scene& scene, const Camera& camera, const Pair& pair) {
  ASSERT_GT(pair.a.patches.size(), 80u);
  EXPECT_GT(pair.matches.size(), pair.a.patches.size() / 4);
  ASSERT_GT(pair.matches.size(), 20u);
  const std::vector<double> errors = errors_px(scene, camera, pair.matches);
  EXPECT_LT(errors[errors.size() / 2], 0.15);
  EXPECT_LT(errors.back(), 0.5);
}

TEST(PatchMatching, FindsTheSpotsOfAPlaneToAFractionOfAPixel) {
  const Scene scene({Wall{}});
  const Pair pair = match_views(scene, pinhole());
  expect_precise(scene, pinhole(), pair);
  for (const SurfaceMatch& m : pair.matches) {
    EXPECT_EQ(m.plane, 0);
    EXPECT_EQ(m.point_in_map, scene.planes[0].centroid);
    EXPECT_EQ(m.normal_in_map, scene.planes[0].normal);
    EXPECT_GE(m.correlation, PatchMatchingOptions().min_correlation);
    EXPECT_LE(m.correlation, 1.0 + 1e-6);
  }
}

TEST(PatchMatching, TheSameViewMatchesItself) {
  const Scene scene({Wall{}});
  const PatchMatchingOptions options;
  const PatchView view =
      prepare_patch_view(scene.photograph(pinhole(), view_a()), scene.plane_buffer(pinhole(), view_a()), {}, options);
  const std::vector<SurfaceMatch> matches = match_patches(view, view, options);
  EXPECT_GT(matches.size(), view.patches.size() / 2);
  for (const SurfaceMatch& m : matches) EXPECT_LT((m.pixel_a - m.pixel_b).norm(), 0.02);
  EXPECT_EQ(patch_overlap(view, view), 1.0);
}

TEST(PatchMatching, SwitchedOffThereAreNone) {
  const Scene scene({Wall{}});
  PatchMatchingOptions options;
  options.enabled = false;
  const PatchView view =
      prepare_patch_view(scene.photograph(pinhole(), view_a()), scene.plane_buffer(pinhole(), view_a()), {}, options);
  EXPECT_TRUE(view.patches.empty());
  EXPECT_TRUE(match_patches(view, view, options).empty());
}

TEST(PatchMatching, FindsThemWhereThePosesAreTenPixelsOff) {
  const Scene scene({Wall{}});
  Shot shot;
  shot.supposed = turned_by(view_b(), 10.0 / 300.0);
  expect_precise(scene, pinhole(), match_views(scene, pinhole(), shot));
}

TEST(PatchMatching, FindsThemInFisheyeImages) {
  const Scene scene({Wall{}});
  expect_precise(scene, fisheye(), match_views(scene, fisheye()));
  Shot shot;
  shot.supposed = turned_by(view_b(), 10.0 / 160.0);
  expect_precise(scene, fisheye(), match_views(scene, fisheye(), shot));
}

TEST(PatchMatching, GainAndOffsetDoNotMatter) {
  const Scene scene({Wall{}});
  Shot shot;
  shot.gain = 0.6;
  shot.offset = 60.0;
  expect_precise(scene, pinhole(), match_views(scene, pinhole(), shot));
}

TEST(PatchMatching, NothingOnAPlaneWithoutTexture) {
  Wall bare;
  bare.contrast = 0.0;
  const Pair pair = match_views(Scene({bare}), pinhole());
  EXPECT_TRUE(pair.matches.empty());
}

TEST(PatchMatching, NothingWhereTheTextureIsAnother) {
  // The wall was painted anew between the two images.
  const PatchMatchingOptions options;
  Wall painted;
  painted.seed = 77;
  const Scene before({Wall{}}), after({painted});
  const PatchView a =
      prepare_patch_view(before.photograph(pinhole(), view_a()), before.plane_buffer(pinhole(), view_a()), {}, options);
  const PatchView b =
      prepare_patch_view(after.photograph(pinhole(), view_b()), after.plane_buffer(pinhole(), view_b()), {}, options);
  EXPECT_GT(a.patches.size(), 80u);
  EXPECT_LE(match_patches(a, b, options).size(), a.patches.size() / 50);
}

TEST(PatchMatching, WhatIsHiddenInTheOtherViewIsNotMatched) {
  // A panel on the right covers other parts of the wall in b, which stands further right, than in a.
  Wall panel;
  panel.depth = 1.6;
  panel.x_from = 0.35;
  panel.seed = 2;
  const Scene scene({Wall{}, panel});
  const Pair pair = match_views(scene, pinhole());
  const auto hidden = [&](const Eigen::Vector2d& pixel_a) {
    const auto [wall, x] = scene.cast(view_a(), *pinhole().unproject(pixel_a));
    const auto [first, y] = scene.cast(view_b(), (view_b() * x).normalized());
    return first != wall;
  };
  const auto num_hidden = std::count_if(pair.a.patches.begin(), pair.a.patches.end(),
                                        [&](const PatchView::Patch& patch) { return hidden(patch.pixel); });
  EXPECT_GE(num_hidden, 5) << "of " << pair.a.patches.size();
  EXPECT_GT(pair.matches.size(), 20u);
  for (const SurfaceMatch& m : pair.matches) EXPECT_FALSE(hidden(m.pixel_a)) << m.pixel_a.transpose();
  const std::vector<double> errors = errors_px(scene, pinhole(), pair.matches);
  EXPECT_LT(errors[errors.size() / 2], 0.15);
}

TEST(PatchMatching, PatchesKeepAwayFromTheBordersOfPlanesAndFromEachOther) {
  Wall panel;
  panel.depth = 1.6;
  panel.x_from = 0.35;
  panel.seed = 2;
  const Scene scene({Wall{}, panel});
  PatchMatchingOptions options;
  options.max_patches = 60;
  const PatchView view =
      prepare_patch_view(scene.photograph(pinhole(), view_a()), scene.plane_buffer(pinhole(), view_a()), {}, options);
  EXPECT_LE(view.patches.size(), 60u);
  ASSERT_GT(view.patches.size(), 20u);
  for (size_t i = 0; i < view.patches.size(); ++i) {
    for (const double x : {-8.0, 8.0}) {
      const Eigen::Vector2d pixel = view.patches[i].pixel + Eigen::Vector2d(x, 0);
      EXPECT_EQ(scene.cast(view_a(), *pinhole().unproject(pixel)).first, view.patches[i].surface.plane_id);
    }
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GE((view.patches[i].pixel - view.patches[j].pixel).norm(), options.min_distance_px - 1e-6);
    }
  }
}

TEST(PatchOverlap, CountsThePatchesThatTheOtherSees) {
  const Scene scene({Wall{}});
  const PatchMatchingOptions options;
  const PatchView view =
      prepare_patch_view(scene.photograph(pinhole(), view_a()), scene.plane_buffer(pinhole(), view_a()), {}, options);
  const auto other_view = [&](const Rigid3& pose) {
    PatchView other;
    other.planes = scene.plane_buffer(pinhole(), pose);
    return other;
  };
  const auto overlap = [&](const Rigid3& pose) { return patch_overlap(view, other_view(pose)); };
  EXPECT_EQ(overlap(view_a()), 1.0);
  // Turned about the vertical by half the field of view of 67 degrees, about half of the patches are left.
  const double half = overlap(perturb_camera(view_a(), 0.5 * 1.176 * Vector6d::Unit(1)));
  EXPECT_GT(half, 0.25);
  EXPECT_LT(half, 0.75);
  EXPECT_EQ(overlap(perturb_camera(view_a(), std::numbers::pi * Vector6d::Unit(1))), 0.0);
  EXPECT_EQ(patch_overlap(PatchView(), other_view(view_a())), 0.0);
}

TEST(PatchMatchingOptions, ValuesOutOfRangeAreErrors) {
  EXPECT_NO_THROW(PatchMatchingOptions().validate());
  const auto expect_refused = [](const std::function<void(PatchMatchingOptions*)>& spoil) {
    PatchMatchingOptions options;
    spoil(&options);
    EXPECT_THROW(options.validate(), Error);
  };
  expect_refused([](PatchMatchingOptions* o) { o->max_patches = 0; });
  expect_refused([](PatchMatchingOptions* o) { o->min_distance_px = 0.0; });
  expect_refused([](PatchMatchingOptions* o) { o->radius_px = 1; });
  expect_refused([](PatchMatchingOptions* o) { o->search_radius_px = -1.0; });
  expect_refused([](PatchMatchingOptions* o) { o->min_correlation = 1.0; });
  expect_refused([](PatchMatchingOptions* o) { o->min_distinction = 1.0; });
}

}  // namespace
}  // namespace cpplus
