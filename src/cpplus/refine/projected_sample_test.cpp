#include "cpplus/refine/projected_sample.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

std::vector<Camera> cameras() {
  return {Camera(CameraModel::kPinhole, 640, 480, {400, 410, 320, 240}),
          Camera(CameraModel::kOpenCv, 640, 480, {400, 410, 320, 240, -0.2, 0.05, 0.001, -0.002}),
          Camera(CameraModel::kOpenCvFisheye, 640, 480, {200, 205, 320, 240, 0.02, -0.01, 0.002, -0.0005}),
          Camera(CameraModel::kEquirectangular, 1024, 512, {1024, 512})};
}

EdgeSample sample_at(const Eigen::Vector3d& x, const Eigen::Vector3d& direction) {
  EdgeSample sample;
  sample.x_in_map = x;
  sample.direction_in_map = direction.normalized();
  return sample;
}

TEST(ProjectSample, DerivativesAreThoseOfDifferences) {
  const Rigid3 pose(Eigen::Quaterniond(so3_exp({-0.4, 0.9, 0.2})), Eigen::Vector3d(1.0, 0.3, -0.7));
  const double h = 1e-6;
  for (const Camera& camera : cameras()) {
    SCOPED_TRACE(camera_model_name(camera.model()));
    const EdgeSample sample = sample_at(inverse(pose) * Eigen::Vector3d(-0.6, 0.5, 3.0), {1, 2, -0.5});
    const auto projected = project_sample(camera, pose, sample);
    ASSERT_TRUE(projected);
    EXPECT_LT((projected->pixel - *camera.project(pose * sample.x_in_map)).norm(), 1e-9);
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = h * Vector6d::Unit(i);
      const Eigen::Vector2d difference = (*camera.project(perturb_camera(pose, step) * sample.x_in_map) -
                                          *camera.project(perturb_camera(pose, -step) * sample.x_in_map)) /
                                         (2 * h);
      EXPECT_LT((projected->d_pixel_d_delta.col(i) - difference).norm(), 1e-4) << "component " << i;
    }
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
      const Eigen::Vector2d difference =
          (*camera.project(pose * (sample.x_in_map + step)) - *camera.project(pose * (sample.x_in_map - step))) /
          (2 * h);
      EXPECT_LT((projected->d_pixel_d_point.col(i) - difference).norm(), 1e-4) << "axis " << i;
    }
    const Eigen::Vector2d tangent =
        *camera.project(pose * (sample.x_in_map + h * sample.direction_in_map)) - projected->pixel;
    EXPECT_NEAR(projected->normal.norm(), 1.0, 1e-12);
    EXPECT_NEAR(projected->normal.dot(tangent.normalized()), 0.0, 1e-4);
  }
}

TEST(ProjectSample, BehindTheCameraThereIsNothing) {
  EXPECT_FALSE(project_sample(cameras()[0], Rigid3(), sample_at({0.1, 0.1, -1.0}, {1, 0, 0})));
  EXPECT_TRUE(project_sample(cameras()[0], Rigid3(), sample_at({0.1, 0.1, 1.0}, {1, 0, 0})));
}

TEST(ProjectSample, AnEdgeThatIsSeenEndOnHasNoNormal) {
  EXPECT_FALSE(project_sample(cameras()[0], Rigid3(), sample_at({0, 0, 2.0}, {0, 0, 1})));
  EXPECT_FALSE(project_sample(cameras()[0], Rigid3(), sample_at({0.3, -0.2, 2.0}, {0.3, -0.2, 2.0})));
  EXPECT_TRUE(project_sample(cameras()[0], Rigid3(), sample_at({0.3, -0.2, 2.0}, {0.3, -0.1, 2.0})));
}

}  // namespace
}  // namespace cpplus
