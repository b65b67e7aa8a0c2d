#include "cpplus/geometry/tangent_box.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

// 90 x 60 pixels of a pinhole camera: X / Z from -0.45 to 0.45, Y / Z from -0.3 to 0.3, and 1 % of the width to spare.
const Camera kPinhole(CameraModel::kPinhole, 90, 60, {100.0, 100.0, 44.5, 29.5});

TEST(TangentBox, OfAPinholeCameraByHand) {
  const TangentBox box = tangent_box(kPinhole);
  ASSERT_TRUE(box.limited);
  EXPECT_NEAR(box.low.x(), -0.459, 1e-5);
  EXPECT_NEAR(box.high.x(), 0.459, 1e-5);
  EXPECT_NEAR(box.low.y(), -0.306, 1e-5);
  EXPECT_NEAR(box.high.y(), 0.306, 1e-5);
}

TEST(TangentBox, ExcludesWhatLiesBesideAndBehind) {
  const TangentBox box = tangent_box(kPinhole);
  EXPECT_FALSE(box.excludes(Eigen::Vector3f(0.89f, 0.59f, 2)));
  EXPECT_TRUE(box.excludes(Eigen::Vector3f(0.93f, 0, 2)));
  EXPECT_TRUE(box.excludes(Eigen::Vector3f(0, -0.63f, 2)));
  EXPECT_TRUE(box.excludes(Eigen::Vector3f(0, 0, -2)));
}

TEST(TangentBox, ABallThatReachesInIsNotExcluded) {
  const TangentBox box = tangent_box(kPinhole);
  EXPECT_FALSE(box.excludes(Eigen::Vector3f(1.2f, 0, 2), 0.3f));
  EXPECT_TRUE(box.excludes(Eigen::Vector3f(1.6f, 0, 2), 0.3f));
  EXPECT_FALSE(box.excludes(Eigen::Vector3f(0, 0, -0.2f), 0.3f));
  EXPECT_TRUE(box.excludes(Eigen::Vector3f(0, 0, -0.4f), 0.3f));
}

TEST(TangentBox, NothingThatADistortedImageShowsIsExcluded) {
  const Camera camera(CameraModel::kOpenCv, 1024, 768, {800, 800, 500, 390, -0.12, 0.05, 0.002, -0.001});
  const TangentBox box = tangent_box(camera);
  ASSERT_TRUE(box.limited);
  for (int y = 0; y < camera.height(); y += 13) {
    for (int x = 0; x < camera.width(); x += 11) {
      EXPECT_FALSE(box.excludes((5 * *camera.unproject(Eigen::Vector2d(x, y))).cast<float>())) << x << " " << y;
    }
  }
}

TEST(TangentBox, OfAPanoramaExcludesNothing) {
  const TangentBox box = tangent_box(Camera(CameraModel::kEquirectangular, 200, 100, {200.0, 100.0}));
  EXPECT_FALSE(box.limited);
  EXPECT_FALSE(box.excludes(Eigen::Vector3f(0, 0, -1)));
  EXPECT_FALSE(box.excludes(Eigen::Vector3f(0, 0, -1), 0.1f));
}

}  // namespace
}  // namespace cpplus
