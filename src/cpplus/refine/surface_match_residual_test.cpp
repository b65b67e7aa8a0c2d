#include "cpplus/refine/surface_match_residual.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace cpplus {
namespace {

std::vector<std::pair<const char*, Camera>> cameras() {
  return {{"PINHOLE", Camera(CameraModel::kPinhole, 640, 480, {400, 410, 320, 240})},
          {"OPENCV", Camera(CameraModel::kOpenCv, 640, 480, {400, 410, 320, 240, -0.2, 0.05, 0.001, -0.002})},
          {"OPENCV_FISHEYE",
           Camera(CameraModel::kOpenCvFisheye, 640, 480, {200, 205, 320, 240, 0.02, -0.01, 0.002, -0.0005})},
          {"EQUIRECTANGULAR", Camera(CameraModel::kEquirectangular, 1024, 512, {1024.0, 512.0})}};
}

Rigid3 pose_a() { return Rigid3(Eigen::Quaterniond(so3_exp({0.3, -1.1, 0.6})), Eigen::Vector3d(0.4, -2.0, 1.5)); }

Rigid3 pose_b() {
  Vector6d delta;
  delta << 0.1, -0.15, 0.2, 0.5, -0.2, 0.3;
  return perturb_camera(pose_a(), delta);
}

// A slanted plane some 3 m before both cameras.
SurfaceMatch plane_ahead() {
  SurfaceMatch match;
  match.point_in_map = inverse(pose_a()) * Eigen::Vector3d(0.2, -0.1, 3.0);
  match.normal_in_map = pose_a().rotation.conjugate() * Eigen::Vector3d(0.4, -0.3, -1.0).normalized();
  return match;
}

// Spots of that plane as both cameras see them.
std::vector<SurfaceMatch> true_matches(const Camera& camera) {
  std::vector<SurfaceMatch> matches;
  SurfaceMatch match = plane_ahead();
  const Eigen::Vector3d u = match.normal_in_map.unitOrthogonal(), v = match.normal_in_map.cross(u);
  for (const double along : {-0.8, 0.0, 0.5}) {
    for (const double beside : {-0.4, 0.0, 0.6}) {
      const Eigen::Vector3d x = match.point_in_map + along * u + beside * v;
      const auto a = camera.project(pose_a() * x), b = camera.project(pose_b() * x);
      if (!a || !b) continue;
      match.pixel_a = *a;
      match.pixel_b = *b;
      matches.push_back(match);
    }
  }
  return matches;
}

// Camera a at the origin looks along z, camera b stands 1 m to its right, the plane is z = 2.
SurfaceMatch match_by_hand() {
  SurfaceMatch match;
  match.pixel_a = {420, 240};
  match.pixel_b = {217, 244};
  match.point_in_map = {5, 5, 2};
  match.normal_in_map = {0, 0, -1};
  return match;
}

Rigid3 right_by(double x) { return Rigid3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-x, 0, 0)); }

TEST(SurfaceMatchResidual, ByHand) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {400, 400, 320, 240});
  // Pixel 420 is 0.25 m a metre to the right: (0.5, 0, 2), which b sees at x = -0.5: 100 px left of its middle.
  const auto r = surface_match_residual(match_by_hand(), camera, Rigid3(), camera, right_by(1.0));
  ASSERT_TRUE(r);
  EXPECT_NEAR(r->residual.x(), 3.0, 1e-9);
  EXPECT_NEAR(r->residual.y(), -4.0, 1e-9);
  // 200 px a metre: a takes the spot along, b leaves it behind.
  EXPECT_NEAR(r->by_a(0, 3), 200.0, 1e-9);
  EXPECT_NEAR(r->by_b(0, 3), -200.0, 1e-9);
  EXPECT_NEAR(r->by_a(1, 4), 200.0, 1e-9);
  // A metre ahead a is a metre from the plane, and its ray meets it at x = 0.25: 50 px less.
  EXPECT_NEAR(r->by_a(0, 5), -50.0, 1e-9);
}

TEST(SurfaceMatchResidual, RangesMayBeTooShortByHand) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {400, 400, 320, 240});
  // A quarter farther along the ray of a: (0.625, 0, 2.5), which b sees at x = -0.375, 60 px left of its middle.
  const auto r = surface_match_residual(match_by_hand(), camera, Rigid3(), camera, right_by(1.0), 0.25);
  ASSERT_TRUE(r);
  EXPECT_NEAR(r->residual.x(), 43.0, 1e-9);
  // The ray of a point 1 m to the left, seen from b: 160 px a metre across it.
  EXPECT_NEAR(r->by_a(0, 3), 160.0, 1e-9);
}

TEST(SurfaceMatchResidual, IsZeroAtTheTruePoses) {
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    const std::vector<SurfaceMatch> matches = true_matches(camera);
    ASSERT_GE(matches.size(), 6u);
    for (const SurfaceMatch& match : matches) {
      const auto r = surface_match_residual(match, camera, pose_a(), camera, pose_b());
      ASSERT_TRUE(r);
      EXPECT_LT(r->residual.norm(), 1e-4);
    }
  }
}

TEST(SurfaceMatchResidual, TheJacobiansAreThoseOfDifferences) {
  constexpr double kStep = 1e-5;
  for (const auto& [name, camera] : cameras()) {
    SCOPED_TRACE(name);
    for (SurfaceMatch match : true_matches(camera)) {
      match.pixel_b += Eigen::Vector2d(4, -7);
      constexpr double kScale = 0.02;
      const auto r = surface_match_residual(match, camera, pose_a(), camera, pose_b(), kScale);
      ASSERT_TRUE(r);
      for (int k = 0; k < 6; ++k) {
        const Vector6d step = kStep * Vector6d::Unit(k);
        const auto difference = [&](double a, double b) {
          const auto moved = [&](double sign) {
            return surface_match_residual(match, camera, perturb_camera(pose_a(), sign * a * step), camera,
                                          perturb_camera(pose_b(), sign * b * step), kScale)
                ->residual;
          };
          return Eigen::Vector2d((moved(1) - moved(-1)) / (2 * kStep));
        };
        EXPECT_LT((difference(1, 0) - r->by_a.col(k)).norm(), 1e-3 * (1.0 + r->by_a.col(k).norm())) << "a " << k;
        EXPECT_LT((difference(0, 1) - r->by_b.col(k)).norm(), 1e-3 * (1.0 + r->by_b.col(k).norm())) << "b " << k;
      }
      const auto scaled = [&](double scale) {
        return surface_match_residual(match, camera, pose_a(), camera, pose_b(), scale)->residual;
      };
      const Eigen::Vector2d by_scale = (scaled(kScale + kStep) - scaled(kScale - kStep)) / (2 * kStep);
      EXPECT_LT((by_scale - r->by_range_scale).norm(), 1e-3 * (1.0 + by_scale.norm()));
    }
  }
}

TEST(SurfaceMatchResidual, TheCamerasMayDiffer) {
  const Camera pinhole = cameras()[0].second, panorama = cameras()[3].second;
  SurfaceMatch match = plane_ahead();
  match.pixel_a = *pinhole.project(pose_a() * match.point_in_map);
  match.pixel_b = *panorama.project(pose_b() * match.point_in_map);
  const auto r = surface_match_residual(match, pinhole, pose_a(), panorama, pose_b());
  ASSERT_TRUE(r);
  EXPECT_LT(r->residual.norm(), 1e-6);
}

TEST(SurfaceMatchResidual, NothingBehindACameraOrAlongThePlane) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {400, 400, 320, 240});
  const auto exists = [&](const SurfaceMatch& match, const Rigid3& b) {
    return surface_match_residual(match, camera, Rigid3(), camera, b).has_value();
  };
  SurfaceMatch match = match_by_hand();
  EXPECT_TRUE(exists(match, right_by(1.0)));
  match.point_in_map.z() = -2.0;
  EXPECT_FALSE(exists(match, right_by(1.0))) << "the plane is behind a";
  match = match_by_hand();
  EXPECT_FALSE(exists(match, Rigid3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -5)))) << "behind b";
  match.normal_in_map = {0, 1, 0};  // pixel_a looks along it
  EXPECT_FALSE(exists(match, right_by(1.0)));
  match.pixel_a.y() = 300;  // and this one meets it 5 m above: 33 m ahead
  EXPECT_TRUE(exists(match, right_by(1.0)));
}

}  // namespace
}  // namespace cpplus
