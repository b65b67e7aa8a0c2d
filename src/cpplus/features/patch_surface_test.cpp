#include "cpplus/features/patch_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

const Eigen::Vector2d kPixel(120.0, 90.0);

// A camera at the origin of the map, and what it sees: no plane instance, and three points a cell whose ranges are
// given by bearing, with noise.
struct View {
  Camera camera = Camera(CameraModel::kPinhole, 240, 180, {200, 200, 119.5, 89.5});
  std::vector<MapPlane> planes;
  PlaneBuffer buffer;
  RangeRaster raster;
  Random random = Random(5);

  explicit View(const std::function<double(const Eigen::Vector3d&)>& range_of, double noise_m = 0.0) {
    buffer.camera = camera;
    buffer.plane = Image<int32_t>(60, 45, PlaneBuffer::kNone);
    raster.range = RangeImage(120, 90, 0.0f);
    raster.points.noise_m = std::max(noise_m, 0.005);
    raster.points.begin = {0};
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        for (int k = 0; k < 3; ++k) {
          const Eigen::Vector2d pixel =
              raster.corner_of({x, y}) + Eigen::Vector2d(random.uniform(0.0, 2.0), random.uniform(0.0, 2.0));
          const double range = range_of(*camera.unproject(pixel)) + noise_m * random.normal();
          raster.points.points.push_back({pixel.cast<float>(), static_cast<float>(range)});
        }
        raster.points.begin.push_back(static_cast<uint32_t>(raster.points.points.size()));
      }
    }
    draw(2);
  }

  // The nearest point of all cells around, as points that are closed by squares show it.
  void draw(int half_cells) {
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        float& nearest = raster.range.at(x, y);
        nearest = 1e9f;
        for (int dy = -half_cells; dy <= half_cells; ++dy) {
          for (int dx = -half_cells; dx <= half_cells; ++dx) {
            for (const auto& point : raster.points_in({x + dx, y + dy})) nearest = std::min(nearest, point.range);
          }
        }
      }
    }
  }

  std::optional<PatchSurface> surface() const { return surface_under(buffer, raster, kPixel, 10.0); }

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
  const auto surface = view.surface();
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->plane_id, PlaneBuffer::kNone);
  EXPECT_LT((surface->plane.normal - kSlanted).norm(), 2e-4);  // bearings are taken to be linear
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0, 1e-4);
  // It lies on the ray of the pixel.
  EXPECT_LT((*view.buffer.camera.project(surface->plane.centroid) - kPixel).norm(), 1e-6);
}

TEST(SurfaceUnder, NoiseOfTheRangesIsItsUncertainty) {
  const View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); }, 0.03);
  const auto surface = view.surface();
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->range_sigma_m, 0.03 / std::sqrt(3.0), 0.003);  // of a cell's three points
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0, 0.01);
}

// 12 cm a pixel: what is drawn in a cell lies half a metre in front of its own points.
TEST(SurfaceUnder, ASteeplySlantedSurfaceIsWhereItsPointsAre) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.0, -0.99, -0.14).normalized();
  View view([&](const Eigen::Vector3d& b) { return range_of_plane(normal, 0.6, b); }, 0.01);
  view.draw(3);
  const double range = range_of_plane(normal, 0.6, *view.camera.unproject(kPixel));
  EXPECT_LT(view.raster.range_at(view.raster.cell_of(kPixel.cast<float>())), range - 0.3);
  const auto surface = view.surface();
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->plane.centroid.norm(), range, 0.004);
  EXPECT_LT(std::acos(surface->plane.normal.dot(normal)), 0.01);
}

TEST(SurfaceUnder, WhatLiesBehindASurfaceDoesNotPullIt) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); }, 0.01);
  for (size_t i = 0; i < view.raster.points.points.size(); i += 3) view.raster.points.points[i].range += 0.5f;
  const auto surface = view.surface();
  ASSERT_TRUE(surface);
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0, 0.004);
}

TEST(SurfaceUnder, FewStrayPointsInFrontAreNoSurfaceManyAreNone) {
  for (const size_t one_in : {50, 4}) {
    View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); }, 0.01);
    for (size_t i = 0; i < view.raster.points.points.size(); i += one_in) {
      view.raster.points.points[i].range -= static_cast<float>(view.random.uniform(0.2, 2.0));
    }
    const auto surface = view.surface();
    EXPECT_EQ(surface.has_value(), one_in == 50);
    if (surface) {
      EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0, 0.004);
    }
  }
}

TEST(SurfaceUnder, NothingAcrossAStep) {
  const View view([](const Eigen::Vector3d& b) { return b.x() < 0.0 ? 3.0 : 3.5; });
  EXPECT_FALSE(view.surface());
}

TEST(SurfaceUnder, NothingWhereTheMapHasHoles) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); });
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 60; ++x) view.raster.range.at(x, y) = 0.0f;
  }
  EXPECT_FALSE(view.surface());
}

TEST(SurfaceUnder, APlaneOfTheMapIsPreferredToItsPoints) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b); });
  view.add_plane(kSlanted, 3.0);
  const auto surface = view.surface();
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->plane_id, 0);
}

TEST(SurfaceUnder, APlaneIsWhereItsPointsInViewHaveIt) {
  for (const double behind_m : {-0.012, 0.0, 0.012}) {
    View view([&](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0, b) + behind_m; }, 0.01);
    view.add_plane(kSlanted, 3.0);
    const auto surface = view.surface();
    ASSERT_TRUE(surface);
    EXPECT_EQ(surface->plane_id, 0);
    EXPECT_EQ(surface->plane.normal, kSlanted);
    const double range = range_of_plane(kSlanted, 3.0, *view.camera.unproject(kPixel));
    EXPECT_NEAR(view.buffer.range_of(surface->plane, kPixel), range + behind_m, 0.002);
  }
}

TEST(SurfaceUnder, WhatStandsInFrontOfThePlaneIsSeenInstead) {
  View view([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 2.5, b); });
  view.add_plane(kSlanted, 3.0);
  const auto surface = view.surface();
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->plane_id, PlaneBuffer::kNone);
  EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -2.5, 1e-4);
}

TEST(SurfaceUnder, APlaneIsNotWhereItsPointsLieBesideIt) {
  for (const double behind_m : {-0.05, 0.05, 0.12}) {
    View view([&](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.0 + behind_m, b); }, 0.01);
    view.add_plane(kSlanted, 3.0);
    const auto surface = view.surface();
    ASSERT_TRUE(surface) << behind_m;
    EXPECT_EQ(surface->plane_id, PlaneBuffer::kNone) << behind_m;
    EXPECT_NEAR(kSlanted.dot(surface->plane.centroid), -3.0 - behind_m, 0.01);
  }
  View without_points([](const Eigen::Vector3d& b) { return range_of_plane(kSlanted, 3.5, b); });
  without_points.raster.points = {};
  without_points.add_plane(kSlanted, 3.0);
  EXPECT_FALSE(without_points.surface()) << "0.5 m behind";
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
