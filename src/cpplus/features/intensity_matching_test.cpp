#include "cpplus/features/intensity_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

/// Brightness and reflectance of the wall z = 3 m, at a place on it (metres).
using Pattern = std::function<double(double x, double y)>;

/// Discs of two shades, one every 40 cm and none where its neighbour is.
double discs(double x, double y) {
  const double u = x - 0.4 * std::floor(x / 0.4) - 0.2, v = y - 0.4 * std::floor(y / 0.4) - 0.2;
  const int shade = (static_cast<int>(std::floor(x / 0.4)) * 7 + static_cast<int>(std::floor(y / 0.4)) * 5) & 3;
  return std::hypot(u, v) < 0.09 + 0.02 * shade ? 0.2 + 0.1 * shade : 0.8;
}

double stripes(double x, double) { return std::abs(x - 0.7 * std::round(x / 0.7)) < 0.1 ? 0.2 : 0.8; }

Camera test_camera() {
  return Camera(CameraModel::kOpenCv, 400, 300, {300, 302, 200, 150, -0.1, 0.02, 0.001, -0.0005});
}

GrayImage photograph(const Pattern& pattern, const Camera& camera, const Rigid3& camera_from_map, double gain = 200.0,
                     double offset = 20.0) {
  GrayImage image(camera.width(), camera.height());
  const Eigen::Vector3d center = camera_center(camera_from_map);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector3d ray = camera_from_map.rotation.conjugate() * *camera.unproject(Eigen::Vector2d(x, y));
      const Eigen::Vector3d on_wall = center + (3.0 - center.z()) / ray.z() * ray;
      image.at(x, y) = static_cast<uint8_t>(std::clamp(gain * pattern(on_wall.x(), on_wall.y()) + offset, 0.0, 255.0));
    }
  }
  return image;
}

/// Points of the wall with the noise of intensities that a LiDAR has, as they fall into the image from a pose.
std::vector<IntensityPoint> scan(const Pattern& pattern, const Camera& camera, const Rigid3& camera_from_map) {
  Random random(3);
  std::vector<IntensityPoint> points;
  for (int k = 0; k < 30000; ++k) {
    IntensityPoint point;
    point.x_in_map = Eigen::Vector3d(random.uniform(-2.5, 2.5), random.uniform(-2, 2), 3.0);
    const double intensity = 100.0 * pattern(point.x_in_map.x(), point.x_in_map.y()) + 5.0 * random.normal();
    point.intensity = static_cast<float>(intensity);
    const auto pixel = camera.project(camera_from_map * point.x_in_map);
    if (!pixel || !camera.in_image(*pixel)) continue;
    point.pixel = pixel->cast<float>();
    points.push_back(point);
  }
  return points;
}

Rigid3 true_pose() {
  return Rigid3(Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 1).normalized())), {0.1, -0.05, 0.2});
}

Rigid3 pose_off(double rotation_rad) {
  Vector6d delta;
  delta << rotation_rad, -0.6 * rotation_rad, 0.3 * rotation_rad, 0.002, -0.003, 0.004;
  return perturb_camera(true_pose(), delta);
}

Matrix6d covariance(double sigma_rad) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(sigma_rad * sigma_rad), Eigen::Vector3d::Constant(1e-6);
  return variances.asDiagonal();
}

std::vector<IntensityMatch> match(const Pattern& pattern, const GrayImage& image, const Rigid3& pose,
                                  double sigma_rad = 0.01, const IntensityMatchingOptions& options = {}) {
  const Camera camera = test_camera();
  return match_intensities(scan(pattern, camera, pose), image, {camera, pose, covariance(sigma_rad)}, options);
}

Eigen::Vector2d error_px(const IntensityMatch& m) { return m.pixel - *test_camera().project(true_pose() * m.x_in_map); }

TEST(MatchIntensities, FindsWhereAWallsPatternIsSeenFromAPoseThatIsSixPixelsOff) {
  const GrayImage image = photograph(discs, test_camera(), true_pose());
  const Rigid3 pose = pose_off(0.018);
  const std::vector<IntensityMatch> matches = match(discs, image, pose);
  ASSERT_GT(matches.size(), 20u);
  std::vector<double> errors;
  double squares = 0.0;
  for (const IntensityMatch& m : matches) {
    errors.push_back(error_px(m).norm());
    squares += error_px(m).dot(m.information * error_px(m));
    EXPECT_GT((*test_camera().project(pose * m.x_in_map) - *test_camera().project(true_pose() * m.x_in_map)).norm(),
              3.0);
    EXPECT_GE(m.correlation, 0.6);
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.35);
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 1.5);
  // Two unknowns each; what they state is careful, not far off.
  EXPECT_LT(squares / static_cast<double>(matches.size()), 2.0);
  EXPECT_GT(squares / static_cast<double>(matches.size()), 0.1);
}

TEST(MatchIntensities, ANegativeAndAnotherUnitGiveTheSamePlaces) {
  const Rigid3 pose = pose_off(0.01);
  const std::vector<IntensityMatch> bright = match(discs, photograph(discs, test_camera(), true_pose()), pose);
  const GrayImage negative = photograph(discs, test_camera(), true_pose(), -200.0, 235.0);
  const std::vector<IntensityMatch> dark = match(discs, negative, pose);
  const Pattern hundredth = [](double x, double y) { return 0.01 * discs(x, y); };
  ASSERT_EQ(bright.size(), dark.size());
  for (size_t k = 0; k < bright.size(); ++k) {
    EXPECT_NEAR((bright[k].pixel - dark[k].pixel).norm(), 0.0, 0.05);
  }
  const Camera camera = test_camera();
  std::vector<IntensityPoint> points = scan(discs, camera, pose);
  for (IntensityPoint& point : points) point.intensity *= 0.0078125f;
  const auto scaled = match_intensities(points, photograph(discs, camera, true_pose()),
                                        {camera, pose, covariance(0.01)}, IntensityMatchingOptions());
  ASSERT_EQ(scaled.size(), bright.size());
  for (size_t k = 0; k < bright.size(); ++k) EXPECT_NEAR((bright[k].pixel - scaled[k].pixel).norm(), 0.0, 1e-3);
}

TEST(MatchIntensities, AStripeIsKnownAcrossItAlone) {
  const GrayImage image = photograph(stripes, test_camera(), true_pose());
  const std::vector<IntensityMatch> matches = match(stripes, image, pose_off(0.01));
  ASSERT_GT(matches.size(), 5u);
  const Eigen::Matrix3d rotation = true_pose().rotation.toRotationMatrix();
  for (const IntensityMatch& m : matches) {
    const Eigen::Vector2d along = (*test_camera().project(true_pose() * m.x_in_map + 0.01 * rotation.col(1)) -
                                   *test_camera().project(true_pose() * m.x_in_map))
                                      .normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    EXPECT_GT(across.dot(m.information * across), 10.0 * along.dot(m.information * along));
    EXPECT_LT(std::abs(across.dot(error_px(m))), 0.8);
  }
}

TEST(MatchIntensities, NothingIsFoundWhereIntensitiesAreNoiseOrTheImageShowsSomethingElse) {
  const Pattern plain = [](double, double) { return 0.5; };
  EXPECT_TRUE(match(plain, photograph(discs, test_camera(), true_pose()), pose_off(0.01)).empty());
  EXPECT_TRUE(match(discs, photograph(plain, test_camera(), true_pose()), pose_off(0.01)).empty());
  Random random(5);
  GrayImage noise(400, 300);
  for (uint8_t& pixel : noise.pixels) pixel = static_cast<uint8_t>(random.uniform(0, 255));
  EXPECT_LT(match(discs, noise, pose_off(0.01)).size(), 4u);
}

TEST(MatchIntensities, APoseThatDoesNotKnowThePlaceToHalfTheRadiusIsNotLookedAt) {
  const GrayImage image = photograph(discs, test_camera(), true_pose());
  EXPECT_GT(match(discs, image, pose_off(0.002), 0.012).size(), 20u);
  EXPECT_TRUE(match(discs, image, pose_off(0.002), 0.02).empty());  // 6 pixels of 10
}

TEST(MatchIntensities, TheLeastDeviationsBoundTheInformation) {
  const GrayImage image = photograph(discs, test_camera(), true_pose());
  IntensityMatchingOptions options;
  options.pixel_sigma_px = 2.0;
  options.map_sigma_m = 0.0;
  for (const IntensityMatch& m : match(discs, image, pose_off(0.0), 0.01, options)) {
    EXPECT_LE(m.information(0, 0), 0.25 + 1e-9);
    EXPECT_LE(m.information(1, 1), 0.25 + 1e-9);
    EXPECT_EQ(m.weight, 0.25);  // each point is in four patches
  }
}

TEST(MatchIntensities, ImagesSmallerThanAPatchAndNoPointsGiveNone) {
  const Camera camera(CameraModel::kPinhole, 40, 30, {30, 30, 20, 15});
  const ExpectedView view{camera, true_pose(), covariance(0.001)};
  EXPECT_TRUE(match_intensities(scan(discs, camera, true_pose()), GrayImage(40, 30, 7), view, {}).empty());
  EXPECT_TRUE(match_intensities({}, GrayImage(40, 30, 7), view, {}).empty());
  EXPECT_TRUE(match_intensities({}, GrayImage(), view, {}).empty());
}

TEST(IntensityMatchingOptions, OutOfRangeIsRefused) {
  const auto refused = [](auto change) {
    IntensityMatchingOptions options;
    change(&options);
    EXPECT_THROW(options.validate(), UsageError);
  };
  IntensityMatchingOptions().validate();
  refused([](auto* o) { o->patch_px = 8; });
  refused([](auto* o) { o->search_radius_px = 1; });
  refused([](auto* o) { o->blur_sigma_px = 0; });
  refused([](auto* o) { o->min_points = 3; });
  refused([](auto* o) { o->max_points = 3; });
  refused([](auto* o) { o->min_correlation = 1.0; });
  refused([](auto* o) { o->points_per_measurement = 0.5; });
  refused([](auto* o) { o->pixel_sigma_px = -1; });
  refused([](auto* o) { o->map_sigma_m = -1; });
}

}  // namespace
}  // namespace cpplus
