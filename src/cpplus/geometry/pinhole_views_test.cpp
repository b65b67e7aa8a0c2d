#include "cpplus/geometry/pinhole_views.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

/// Every pixel of the view lies in the recorded image.
void expect_no_pixel_from_outside(const Camera& camera, const Camera& view) {
  size_t num_outside = 0;
  for (int y = 0; y < view.height(); ++y) {
    for (int x = 0; x < view.width(); ++x) {
      const auto pixel = camera.project(*view.unproject(Eigen::Vector2d(x, y)));
      num_outside += pixel && camera.in_image(*pixel, -0.5) ? 0 : 1;
    }
  }
  EXPECT_EQ(num_outside, 0u);
}

TEST(PinholeViews, APinholeCameraStaysAsItIs) {
  const Camera camera(CameraModel::kSimplePinhole, 64, 48, {50, 30.25, 20.5});
  const auto views = pinhole_views(camera, {});
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].camera.model(), CameraModel::kPinhole);
  EXPECT_EQ(views[0].camera.width(), 64);
  EXPECT_EQ(views[0].camera.params(), (std::vector<double>{50, 50, 30.25, 20.5}));
  EXPECT_EQ(views[0].suffix, "");
}

TEST(PinholeViews, CenteredCutsToThePartThatIsSymmetric) {
  // Left of the principal point there are 20 pixels (border at -0.5), right of it 44; above 30, below 18.
  const Camera camera(CameraModel::kPinhole, 64, 48, {50, 60, 19.5, 29.5});
  PinholeViewOptions options;
  options.centered = true;
  const Camera view = pinhole_views(camera, options).at(0).camera;
  EXPECT_EQ(view.width(), 40);
  EXPECT_EQ(view.height(), 36);
  EXPECT_EQ(view.params(), (std::vector<double>{50, 60, 19.5, 17.5}));  // the middle of the image
}

TEST(PinholeViews, DistortedCamerasKeepTheirScaleAndShowNothingFromOutside) {
  const Camera cameras[] = {
      Camera(CameraModel::kSimpleRadial, 320, 240, {200, 150, 125, -0.2}),
      Camera(CameraModel::kRadial, 320, 240, {200, 150, 125, 0.15, 0.02}),
      Camera(CameraModel::kOpenCv, 320, 240, {200, 205, 165, 115, -0.1, 0.01, 0.002, -0.003}),
      Camera(CameraModel::kOpenCvFisheye, 320, 240, {110, 110, 160, 118, 0.01, -0.002, 0, 0}),
  };
  for (const Camera& camera : cameras) {
    for (const bool centered : {false, true}) {
      SCOPED_TRACE(camera_model_name(camera.model()));
      PinholeViewOptions options;
      options.centered = centered;
      const Camera view = pinhole_views(camera, options).at(0).camera;
      expect_no_pixel_from_outside(camera, view);
      EXPECT_EQ(view.params()[0], camera.params()[0]);
      EXPECT_GE(view.width(), 240);  // not much is lost
      if (centered) {
        EXPECT_EQ(view.params()[2], 0.5 * (view.width() - 1));
        EXPECT_EQ(view.params()[3], 0.5 * (view.height() - 1));
      }
    }
  }
}

TEST(PinholeViews, AFisheyeIsCutOffAtTheLargestAngle) {
  // Equidistant, 100 px a radian, 3.6 radians across: 206 degrees.
  const Camera camera(CameraModel::kOpenCvFisheye, 360, 360, {100, 100, 179.5, 179.5, 0, 0, 0, 0});
  PinholeViewOptions options;
  options.max_fov_deg = 90.0;
  const Camera view = pinhole_views(camera, options).at(0).camera;
  EXPECT_EQ(view.width(), 200);  // 2 * 100 * tan(45 deg)
  EXPECT_EQ(view.height(), 200);
}

TEST(PinholeViews, APanoramaGivesTheFacesOfACube) {
  const Camera camera(CameraModel::kEquirectangular, 628, 314, {628, 314});
  const auto views = pinhole_views(camera, {});
  ASSERT_EQ(views.size(), 6u);
  // What is to the right of the camera is ahead of the right face, and so on.
  const std::pair<const char*, Eigen::Vector3d> ahead[] = {{"_front", {0, 0, 1}}, {"_right", {1, 0, 0}},
                                                           {"_back", {0, 0, -1}}, {"_left", {-1, 0, 0}},
                                                           {"_up", {0, -1, 0}},   {"_down", {0, 1, 0}}};
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(views[i].suffix, ahead[i].first);
    EXPECT_NEAR((views[i].view_from_camera * ahead[i].second - Eigen::Vector3d::UnitZ()).norm(), 0.0, 1e-12);
    EXPECT_EQ(views[i].camera.width(), 200);  // 628 / pi
    EXPECT_EQ(views[i].camera.params()[0], 100.0);
  }
  // The horizon stays the horizon: down is down in the side faces.
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR((views[i].view_from_camera * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-12);
  }
}

TEST(PinholeViews, ThrowsWhereNothingIsLeft) {
  const Camera camera(CameraModel::kSimpleRadial, 64, 48, {50, 2.0, 20, -0.1});
  PinholeViewOptions options;
  options.centered = true;
  EXPECT_THROW(pinhole_views(camera, options), Error);
  options.max_fov_deg = 171;
  EXPECT_THROW(pinhole_views(camera, options), Error);
}

}  // namespace
}  // namespace cpplus
