#include "cpplus/features/patch_surface.h"

#include <gtest/gtest.h>

#include <functional>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

const Eigen::Vector2d kPixel(120.0, 90.0);

// A camera at the origin of the map, and what it sees: no plane instance, and points whose ranges are given by bearing.
struct View {
  std::vector<MapPlane> planes;
  PlaneBuffer buffer;
  RangeRaster raster;

  explicit View(const std::function<double(const Eigen::Vector3d&)>& range_of, double noise_m = 0.0) {
    const Camera camera(CameraModel::kPinhole, 240, 180, {200, 200, 119.5, 89.5});
    buffer.camera = camera;
    buffer.plane = Image<int32_t>(60, 45, PlaneBuffer::kNone);
    raster.range = RangeImage(120, 90, 0.0f);
    raster.mean_range = RangeImage(120, 90, 0.0f);
    raster.num_points = Image<uint16_t>(120, 90, 3);
    Random random(5);
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        const auto bearing = camera.unproject(raster.corner_of({x, y}) + Eigen::Vector2d(1, 1));
        const double range = range_of(*bearing);
        raster.range.at(x, y) = static_cast<float>(range - 0.02);  // the nearest of several points
        raster.mean_range.at(x, y) = static_cast<float>(range + noise_m * random.normal());
      }
    }
  }

  void add_plane(const Eigen::Vector3d& normal, double distance) {
    planes.push_back({normal, -distance * normal, 0.0, 100});
    buffer.planes = &planes;
    for (int32_t& id : buffer.plane.pixels) id = 0;
  }
};

// n . x = -d for the plane with the normal n towards the camera.
double range_of_plane(const Eigen::Vector3d& normal, double distance, const Eigen::Vector3d& bearing) {
  return -distance / normal.dot(bearing);
}

const Eigen::Vector3d kSlanted = Eigen::Vector3d(0.5, -0.3, -1.0).normalized();

TEST(SurfaceUnder, ATangentPlaneIsFoundInTheRanges) {
  const View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); });
  const auto surface = surface_under(view.buffer, view.raster, kPixel, 10.0);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->plane_id, PlaneBuffer::kNone);
  EXPECT_LT((surface->plane.normal - kSlanted).norm(), 1e-4);
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0, 1e-4);
  // It lies on the ray of the pixel.
  EXPECT_LT((*view.buffer.camera.project(surface->plane.centroid) - kPixel).norm(), 1e-6);
}

TEST(SurfaceUnder, NoiseOfTheRangesIsItsUncertainty) {
  const View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); }, 0.015);
  const auto surface = surface_under(view.buffer, view.raster, kPixel, 10.0);
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->range_sigma_m, 0.015, 0.003);
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0, 0.01);
}

TEST(SurfaceUnder, NothingAcrossAStep) {
  const View view([](const Eigen::Vector3d& b) { return b.x() < 0.0 ? 3.0 : 3.5; });
  EXPECT_FALSE(surface_under(view.buffer, view.raster, kPixel, 10.0));
}

TEST(SurfaceUnder, NothingWhereTheMapHasHoles) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); });
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 60; ++x) view.raster.range.at(x, y) = 0.0f;
  }
  EXPECT_FALSE(surface_under(view.buffer, view.raster, kPixel, 10.0));
}

TEST(SurfaceUnder, APlaneOfTheMapIsPreferredToItsPoints) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); });
  view.add_plane(kSlanted, 3.0);
  const auto surface = surface_under(view.buffer, view.raster, kPixel, 10.0);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->plane_id, 0);
}

TEST(SurfaceUnder, WhatStandsInFrontOfThePlaneIsSeenInstead) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 2.5, b); });
  view.add_plane(kSlanted, 3.0);
  const auto surface = surface_under(view.buffer, view.raster, kPixel, 10.0);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->plane_id, PlaneBuffer::kNone);
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -2.5, 1e-4);
}

TEST(SurfaceUnder, APlaneIsNotWhereItsPointsLieBesideIt) {
  for (const double behind_m : {-0.05, 0.05, 0.12}) {
    View view([&](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0 + behind_m, b); }, 0.01);
    view.add_plane(kSlanted, 3.0);
    const auto surface = surface_under(view.buffer, view.raster, kPixel, 10.0);
    ASSERT_TRUE(surface) << behind_m;
    EXPECT_EQ(surface->plane_id, PlaneBuffer::kNone) << behind_m;
    EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0 - behind_m, 0.01);
  }
  View without_points([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.5, b); });
  without_points.raster.num_points = Image<uint16_t>(120, 90, 0);
  without_points.add_plane(kSlanted, 3.0);
  EXPECT_FALSE(surface_under(without_points.buffer, without_points.raster, kPixel, 10.0)) << "0.5 m behind";
}

TEST(IsSeen, WhatIsBehindTheSurfaceIsNot) {
  const View view([](const Eigen::Vector3d&) { return 3.0; });
  EXPECT_TRUE(is_seen(view.raster, kPixel, 3.0));
  EXPECT_TRUE(is_seen(view.raster, kPixel, 1.0));
  EXPECT_FALSE(is_seen(view.raster, kPixel, 4.0));
  EXPECT_TRUE(is_seen(RangeRaster(), kPixel, 4.0));  // where nothing is drawn nothing hides
}

}  // namespace
}  // namespace cpplus
