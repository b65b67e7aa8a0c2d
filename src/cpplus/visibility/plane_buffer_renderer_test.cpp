#include "cpplus/visibility/plane_buffer_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

// Rectangles of points every 2 cm, each a plane instance.
class Surfaces {
 public:
  void add(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    MapPlane plane;
    plane.normal = u.cross(v).normalized();
    plane.centroid = corner + 0.5 * (u + v);
    const int nu = static_cast<int>(std::lround(u.norm() / 0.02));
    const int nv = static_cast<int>(std::lround(v.norm() / 0.02));
    for (int i = 0; i < nu; ++i) {
      for (int j = 0; j < nv; ++j) {
        cloud_.positions.push_back((corner + (i + 0.5) / nu * u + (j + 0.5) / nv * v).cast<float>());
        plane_of_input_.push_back(static_cast<int32_t>(planes_.planes.size()));
        ++plane.num_points;
      }
    }
    planes_.planes.push_back(plane);
  }

  // The camera stands at the origin with the map's axes.
  PlaneBuffer render(const Camera& camera) {
    const VoxelMap map(cloud_, {});
    planes_.plane_of_point.resize(map.num_points());
    for (size_t i = 0; i < map.num_points(); ++i) {
      planes_.plane_of_point[i] = plane_of_input_[map.input_index(i)];
    }
    const PlaneBufferOptions options;
    return render_plane_buffer(map, planes_, collect_plane_surface(map, planes_, options), camera, Rigid3(), options);
  }

 private:
  PointCloud cloud_;
  std::vector<int32_t> plane_of_input_;
  PlaneSegmentation planes_;
};

Camera pinhole() { return Camera(CameraModel::kPinhole, 320, 240, {160, 160, 159.5, 119.5}); }

bool visible(const PlaneBuffer& buffer, const Eigen::Vector3d& x) {
  return buffer.is_visible(x, *buffer.camera.project(x), 0.04);
}

TEST(RenderPlaneBuffer, TheNearestPlaneIsSeenWithoutHoles) {
  Surfaces surfaces;
  surfaces.add({-3, -3, 4}, {6, 0, 0}, {0, 6, 0});
  surfaces.add({-0.5, -0.5, 2}, {1, 0, 0}, {0, 1, 0});
  const PlaneBuffer buffer = surfaces.render(pinhole());
  // The square in front covers 160 * 0.5 / 2 = 40 px on each side of the middle.
  for (double y = 8; y < 232; y += 3) {
    for (double x = 44; x < 276; x += 3) {
      const double off = std::max(std::abs(x - 159.5), std::abs(y - 119.5));
      if (std::abs(off - 40) < 8) continue;
      ASSERT_EQ(buffer.plane_at({x, y}), off < 40 ? 1 : 0) << x << " " << y;
    }
  }
  EXPECT_FALSE(visible(buffer, {0.2, 0.1, 3.0}));
  EXPECT_TRUE(visible(buffer, {0.9, 0.1, 3.0}));
  EXPECT_FALSE(visible(buffer, {0.9, 0.1, 4.5}));
}

TEST(RenderPlaneBuffer, WhatIsAsSmallAsAPieceOfAPersonHidesNothing) {
  // A flat piece of a body, 20 x 20 cm: 100 points.
  Surfaces surfaces;
  surfaces.add({-3, -3, 4}, {6, 0, 0}, {0, 6, 0});
  surfaces.add({-0.1, -0.1, 2}, {0.2, 0, 0}, {0, 0.2, 0});
  const PlaneBuffer buffer = surfaces.render(pinhole());
  EXPECT_EQ(buffer.plane_at({159.5, 119.5}), 0);
  EXPECT_TRUE(visible(buffer, {0, 0, 3.5}));
}

TEST(RenderPlaneBuffer, AGrazingFloorHidesNothingOnItselfAndAllBelow) {
  // Seen at 2 to 20 degrees, its patches overlap one another many times.
  Surfaces surfaces;
  surfaces.add({-1, 0.4, 0.8}, {2, 0, 0}, {0, 0, 9});
  const PlaneBuffer buffer = surfaces.render(pinhole());
  for (double z = 1.2; z < 9; z += 0.05) {
    ASSERT_TRUE(visible(buffer, {0.1, 0.4, z})) << z;
    ASSERT_TRUE(visible(buffer, {0.1, 0.3, z})) << z;
  }
  for (double z = 1.2; z < 6; z += 0.05) ASSERT_FALSE(visible(buffer, {0.1, 0.55, z})) << z;
}

TEST(RenderPlaneBuffer, AFisheyeSeesPlanesBesideAndBehindItself) {
  // 180 degrees across the image's width: walls left, right and ahead, seen at up to 88 degrees.
  const double f = 160 / (std::numbers::pi / 2);
  const Camera fisheye(CameraModel::kOpenCvFisheye, 320, 320, {f, f, 159.5, 159.5, 0, 0, 0, 0});
  Surfaces surfaces;
  surfaces.add({-2, -1.5, -1}, {0, 3, 0}, {0, 0, 5});
  surfaces.add({2, -1.5, -1}, {0, 0, 5}, {0, 3, 0});
  surfaces.add({-2, -1.5, 4}, {0, 3, 0}, {4, 0, 0});
  const PlaneBuffer buffer = surfaces.render(fisheye);
  const auto pixel_of = [&](double angle_deg) {
    const double angle = angle_deg * std::numbers::pi / 180;
    return *fisheye.project({std::sin(angle), 0, std::cos(angle)});
  };
  EXPECT_EQ(buffer.plane_at(pixel_of(-86)), 0);
  EXPECT_EQ(buffer.plane_at(pixel_of(-45)), 0);
  EXPECT_EQ(buffer.plane_at(pixel_of(0)), 2);
  EXPECT_EQ(buffer.plane_at(pixel_of(45)), 1);
  EXPECT_EQ(buffer.plane_at(pixel_of(86)), 1);
  EXPECT_FALSE(visible(buffer, {2.5, 0, 0.1}));
  EXPECT_TRUE(visible(buffer, {1.5, 0, 0.1}));
}

TEST(RenderPlaneBuffer, AnEmptyMapHidesNothing) {
  Surfaces surfaces;
  const PlaneBuffer buffer = surfaces.render(pinhole());
  EXPECT_EQ(buffer.plane_at({100, 100}), PlaneBuffer::kNone);
  EXPECT_TRUE(visible(buffer, {0, 0, 50}));
}

TEST(PlaneBufferOptions, ValuesOutOfRangeAreErrors) {
  PlaneBufferOptions options;
  EXPECT_NO_THROW(options.validate());
  options.cell_px = 0.5;
  EXPECT_THROW(options.validate(), Error);
}

}  // namespace
}  // namespace cpplus
