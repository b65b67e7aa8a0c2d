#include "cpplus/geometry/scaled_camera.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(ScaledCamera, PointsStayAtTheSameShareOfTheImage) {
  const std::vector<Camera> cameras = {
      Camera(CameraModel::kOpenCv, 640, 480, {500, 510, 321, 238, -0.1, 0.02, 0.001, -0.001}),
      Camera(CameraModel::kSimpleRadial, 640, 480, {500, 321, 238, -0.1}),
      Camera(CameraModel::kOpenCvFisheye, 640, 480, {300, 301, 320, 240, 0.01, 0, 0, 0}),
      Camera(CameraModel::kEquirectangular, 640, 320, {640, 320}),
  };
  const Eigen::Vector3d x_in_camera(0.4, -0.3, 2.0);
  for (const Camera& camera : cameras) {
    const Camera half = scaled_camera(camera, 0.5);
    EXPECT_EQ(half.width(), 320);
    const Eigen::Vector2d pixel = *camera.project(x_in_camera);
    const Eigen::Vector2d half_pixel = *half.project(x_in_camera);
    // Shares are counted from the border, half a pixel before the first centre.
    EXPECT_NEAR((half_pixel.x() + 0.5) / half.width(), (pixel.x() + 0.5) / camera.width(), 1e-12);
    EXPECT_NEAR((half_pixel.y() + 0.5) / half.height(), (pixel.y() + 0.5) / camera.height(), 1e-12);
    EXPECT_EQ(scaled_camera(camera, 1.0).params(), camera.params());
  }
}

}  // namespace
}  // namespace cpplus
