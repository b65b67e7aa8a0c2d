#include "cpplus/geometry/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using ::testing::HasSubstr;
using Jacobian = Eigen::Matrix<double, 2, 3>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct NamedCamera {
  std::string name;
  Camera camera;
};

/// Every model with the strength of distortion that real lenses have; all cover their whole image.
std::vector<NamedCamera> all_cameras() {
  return {
      {"simple_pinhole", Camera(CameraModel::kSimplePinhole, 640, 480, {500, 320.3, 240.1})},
      {"pinhole", Camera(CameraModel::kPinhole, 640, 480, {500, 510, 320.3, 240.1})},
      {"simple_radial", Camera(CameraModel::kSimpleRadial, 640, 480, {450, 320, 240, -0.12})},
      {"radial", Camera(CameraModel::kRadial, 640, 480, {450, 320, 240, -0.28, 0.09})},
      {"opencv", Camera(CameraModel::kOpenCv, 1024, 768, {667, 660, 514.8, 378.8, -0.105, 0.032, 0.0007, -0.0005})},
      {"opencv_wide", Camera(CameraModel::kOpenCv, 1280, 720, {620, 622, 641, 355, -0.31, 0.11, 0.0009, -0.0004})},
      {"full_opencv", Camera(CameraModel::kFullOpenCv, 1920, 1080,
                             {900, 905, 955, 545, 5.1, 3.2, 0.0003, -0.0002, 0.18, 5.4, 4.7, 0.95})},
      {"fisheye", Camera(CameraModel::kOpenCvFisheye, 1000, 900, {330, 331, 500, 448, 0.02, -0.004, 0.0005, -0.00003})},
      {"fisheye_180", Camera(CameraModel::kOpenCvFisheye, 1280, 1280, {400, 400, 639.5, 639.5, 0.01, -0.001, 0, 0})},
      {"equirectangular", Camera(CameraModel::kEquirectangular, 2048, 1024, {2048, 1024})},
  };
}

void expect_pixel(const Camera& camera, const Eigen::Vector3d& point, double column, double row) {
  const std::optional<Eigen::Vector2d> pixel = camera.project(point);
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), column, 1e-9);
  EXPECT_NEAR(pixel->y(), row, 1e-9);
}

std::string error_of(CameraModel model, int width, int height, const std::vector<double>& params) {
  try {
    Camera(model, width, height, params);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// ---- values by hand: x = 0.5, y = 0.25, s = 0.3125 unless stated ----

const Eigen::Vector3d kPoint(1.0, 0.5, 2.0);

TEST(CameraByHand, Pinholes) {
  expect_pixel(Camera(CameraModel::kSimplePinhole, 640, 480, {100, 10, 20}), kPoint, 60, 45);
  expect_pixel(Camera(CameraModel::kPinhole, 640, 480, {100, 200, 10, 20}), kPoint, 60, 70);
}

TEST(CameraByHand, RadialModels) {
  // g = 1 + 0.1 * 0.3125 = 1.03125
  expect_pixel(Camera(CameraModel::kSimpleRadial, 640, 480, {100, 10, 20, 0.1}), kPoint, 61.5625, 45.78125);
  // + 0.2 * 0.09765625 = 1.05078125
  expect_pixel(Camera(CameraModel::kRadial, 640, 480, {100, 10, 20, 0.1, 0.2}), kPoint, 62.5390625, 46.26953125);
}

TEST(CameraByHand, OpenCv) {
  // u = 0.525390625 + 2 * 0.01 * 0.125 + 0.02 * (0.3125 + 0.5)  = 0.544140625
  // v = 0.2626953125 + 0.01 * (0.3125 + 0.125) + 2 * 0.02 * 0.125 = 0.2720703125
  expect_pixel(Camera(CameraModel::kOpenCv, 640, 480, {100, 200, 10, 20, 0.1, 0.2, 0.01, 0.02}), kPoint, 64.4140625,
               74.4140625);
}

TEST(CameraByHand, FullOpenCv) {
  // s = 1 (x = 1, y = 0): g = (1 + 0.1 + 0.2 + 0.3) / (1 + 0.1 + 0.5 + 0.4) = 0.8; u = 0.8 + 0.02 * 3, v = 0.01
  expect_pixel(Camera(CameraModel::kFullOpenCv, 640, 480, {100, 200, 10, 20, 0.1, 0.2, 0.01, 0.02, 0.3, 0.1, 0.5, 0.4}),
               Eigen::Vector3d(2, 0, 2), 96, 22);
}

TEST(CameraByHand, Fisheye) {
  const Camera equidistant(CameraModel::kOpenCvFisheye, 640, 640, {100, 200, 320, 300, 0, 0, 0, 0});
  expect_pixel(equidistant, Eigen::Vector3d(3, 0, 3), 320 + 25 * M_PI, 300);
  expect_pixel(equidistant, Eigen::Vector3d(0, -7, 0), 320, 300 - 100 * M_PI);  // 90 degrees from the axis
  expect_pixel(equidistant, Eigen::Vector3d(0, 0, 5), 320, 300);
  const double t = M_PI / 4;
  const Camera distorted(CameraModel::kOpenCvFisheye, 640, 640, {100, 200, 320, 300, 0.1, 0.01, 0.001, 0.0001});
  expect_pixel(
      distorted, Eigen::Vector3d(3, 0, 3),
      320 + 100 * (t + 0.1 * std::pow(t, 3) + 0.01 * std::pow(t, 5) + 0.001 * std::pow(t, 7) + 0.0001 * std::pow(t, 9)),
      300);
}

TEST(CameraByHand, EquirectangularFourWindsAndHalfwayUp) {
  const Camera camera(CameraModel::kEquirectangular, 400, 200, {400, 200});
  expect_pixel(camera, Eigen::Vector3d(0, 0, 2), 199.5, 99.5);
  expect_pixel(camera, Eigen::Vector3d(2, 0, 0), 299.5, 99.5);
  expect_pixel(camera, Eigen::Vector3d(-2, 0, 0), 99.5, 99.5);
  expect_pixel(camera, Eigen::Vector3d(0, 1, 1), 199.5, 149.5);    // down: larger rows
  expect_pixel(camera, Eigen::Vector3d(0, 0, -2), 399.5, 99.5);    // the seam
  expect_pixel(camera, Eigen::Vector3d(-0.0, 0, -2), -0.5, 99.5);  // its other side
}

// ---- OpenCV ----

TEST(CameraAgainstOpenCv, PerspectiveModels) {
  for (const auto& [name, camera] : all_cameras()) {
    const std::vector<double>& p = camera.params();
    std::vector<double> d;
    switch (camera.model()) {
      case CameraModel::kSimpleRadial:
        d = {p[3], 0, 0, 0};
        break;
      case CameraModel::kRadial:
        d = {p[3], p[4], 0, 0};
        break;
      case CameraModel::kOpenCv:
        d = {p[4], p[5], p[6], p[7]};
        break;
      case CameraModel::kFullOpenCv:
        d = {p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]};
        break;
      default:
        continue;
    }
    const size_t c = *camera_model_principal_point_index(camera.model());
    const cv::Matx33d k(p[0], 0, p[c], 0, p[c - 1], p[c + 1], 0, 0, 1);
    Random random(3);
    for (int i = 0; i < 200; ++i) {
      const cv::Point3d point(random.uniform(-0.7, 0.7), random.uniform(-0.5, 0.5), 1.0);
      std::vector<cv::Point2d> pixels;
      cv::projectPoints(std::vector<cv::Point3d>{point}, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), k, d, pixels);
      SCOPED_TRACE(name);
      expect_pixel(camera, 3.0 * Eigen::Vector3d(point.x, point.y, point.z), pixels[0].x, pixels[0].y);
    }
  }
}

TEST(CameraAgainstOpenCv, Fisheye) {
  const std::vector<double> p = {330, 331, 500, 448, 0.02, -0.012, 0.004, -0.001};
  const Camera camera(CameraModel::kOpenCvFisheye, 1000, 900, p);
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const cv::Point3d point(random.uniform(-3, 3), random.uniform(-3, 3), 1.0);
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{point}, pixels, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0),
                               cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1), cv::Vec4d(p[4], p[5], p[6], p[7]));
    expect_pixel(camera, 2.0 * Eigen::Vector3d(point.x, point.y, point.z), pixels[0].x, pixels[0].y);
  }
}

// ---- identities on every model ----

/// Calls visit(pixel) on a grid over the image that includes its corners.
template <typename Visit>
void for_grid(const Camera& camera, int steps, const Visit& visit) {
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      visit(Eigen::Vector2d((camera.width() - 1.0) * i / steps, (camera.height() - 1.0) * j / steps));
    }
  }
}

TEST(CameraIdentity, ProjectUndoesUnprojectOverTheWholeImage) {
  for (const auto& [name, camera] : all_cameras()) {
    int tried = 0;
    int inverted = 0;
    for_grid(camera, 40, [&](const Eigen::Vector2d& pixel) {
      ++tried;
      const std::optional<Eigen::Vector3d> bearing = camera.unproject(pixel);
      if (!bearing) return;
      EXPECT_NEAR(bearing->norm(), 1.0, 1e-12) << name;
      const std::optional<Eigen::Vector2d> again = camera.project(7.0 * *bearing);
      ASSERT_TRUE(again.has_value()) << name << " " << pixel.transpose();
      EXPECT_LT((*again - pixel).norm(), 1e-9) << name << " " << pixel.transpose();
      ++inverted;
    });
    EXPECT_EQ(inverted, tried) << name;
  }
}

TEST(CameraIdentity, JacobianEqualsCentralDifferences) {
  for (const auto& [name, camera] : all_cameras()) {
    for_grid(camera, 12, [&](const Eigen::Vector2d& at) {
      const Eigen::Vector3d point = 4.0 * camera.unproject(at).value();
      Eigen::Vector2d pixel;
      Jacobian analytic;
      ASSERT_TRUE(camera.project(point, &pixel, &analytic)) << name;
      EXPECT_LT((pixel - at).norm(), 1e-9) << name;
      Jacobian numeric;
      const double step = 1e-5;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d delta = step * Eigen::Vector3d::Unit(axis);
        Eigen::Vector2d difference = *camera.project(point + delta) - *camera.project(point - delta);
        // Next to the seam of a panorama the two points fall on opposite sides of the image.
        if (camera.model() == CameraModel::kEquirectangular) {
          difference.x() -= camera.width() * std::round(difference.x() / camera.width());
        }
        numeric.col(axis) = difference / (2.0 * step);
      }
      EXPECT_LT((analytic - numeric).norm(), 1e-5 * (1.0 + numeric.norm())) << name << " " << at.transpose();
    });
  }
}

TEST(CameraIdentity, FisheyeJacobianOnTheAxis) {
  const Camera camera(CameraModel::kOpenCvFisheye, 640, 640, {100, 200, 320, 300, 0.1, 0, 0, 0});
  Eigen::Vector2d pixel;
  Jacobian jacobian;
  ASSERT_TRUE(camera.project(Eigen::Vector3d(0, 0, 4), &pixel, &jacobian));
  EXPECT_TRUE(jacobian.isApprox((Jacobian() << 25, 0, 0, 0, 50, 0).finished(), 1e-12));
  Jacobian beside;  // just outside the branch for the axis
  ASSERT_TRUE(camera.project(Eigen::Vector3d(4e-8, 4e-8, 4), &pixel, &beside));
  EXPECT_LT((jacobian - beside).norm(), 1e-5);
}

// ---- validity ----

TEST(CameraValidity, NothingBehindAPerspectiveCameraNorAtItsCentre) {
  for (const auto& [name, camera] : all_cameras()) {
    EXPECT_FALSE(camera.project(Eigen::Vector3d::Zero()).has_value()) << name;
    EXPECT_FALSE(camera.project(Eigen::Vector3d(0.1, kNan, 1)).has_value()) << name;
    EXPECT_FALSE(camera.project(Eigen::Vector3d(kNan, 0.1, 1)).has_value()) << name;
    EXPECT_FALSE(camera.project(Eigen::Vector3d(0.1, 0.2, kNan)).has_value()) << name;
    EXPECT_FALSE(camera.unproject(Eigen::Vector2d(kNan, 10)).has_value()) << name;
    const bool sees_behind =
        camera.model() == CameraModel::kOpenCvFisheye || camera.model() == CameraModel::kEquirectangular;
    if (sees_behind) continue;
    for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.2, 0.1, -3),
                                         Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(1, 1, -1e-12)}) {
      EXPECT_FALSE(camera.project(point).has_value()) << name << " " << point.transpose();
    }
  }
}

TEST(CameraValidity, WideAnglesDoNotWrapBackIntoTheImage) {
  // Barrel lenses whose polynomial turns round; the last one has a pole of the rational factor at s = 2.
  const std::vector<NamedCamera> cameras = {
      {"simple_radial", Camera(CameraModel::kSimpleRadial, 640, 480, {450, 320, 240, -0.12})},
      {"radial", Camera(CameraModel::kRadial, 640, 480, {450, 320, 240, -0.28, 0.01})},
      {"opencv", Camera(CameraModel::kOpenCv, 1280, 720, {620, 622, 641, 355, -0.31, 0.06, 0.0009, -0.0004})},
      {"full_opencv", Camera(CameraModel::kFullOpenCv, 640, 480, {450, 450, 320, 240, -0.3, 0, 0, 0, 0, -0.5, 0, 0})},
      {"fisheye", Camera(CameraModel::kOpenCvFisheye, 1000, 1000, {330, 330, 500, 500, -0.05, -0.01, 0, 0})},
  };
  for (const auto& [name, camera] : cameras) {
    for (const double azimuth : {0.0, 0.6, 2.0, 3.5, 5.0}) {
      double last_radius = 0.0;
      bool ended = false;
      for (double angle = 0.005; angle < M_PI; angle += 0.005) {
        const Eigen::Vector3d point(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                                    std::cos(angle));
        const std::optional<Eigen::Vector2d> pixel = camera.project(point);
        if (!pixel) ended = true;
        if (!pixel) continue;
        ASSERT_FALSE(ended) << name << ": valid again beyond the limit, at " << angle;
        const size_t c = *camera_model_principal_point_index(camera.model());
        const double radius = (*pixel - Eigen::Vector2d(camera.params()[c], camera.params()[c + 1])).norm();
        EXPECT_GT(radius, last_radius) << name << " " << angle;
        last_radius = radius;
        const std::optional<Eigen::Vector3d> bearing = camera.unproject(*pixel);
        ASSERT_TRUE(bearing.has_value()) << name << " " << angle;
        EXPECT_LT((*bearing - point).norm(), 1e-6) << name << " " << angle;
      }
      EXPECT_TRUE(ended) << name;
    }
  }
}

TEST(CameraValidity, LimitIsWhereTheDistortedRadiusTurns) {
  // r - 0.12 r^3 rises up to r = 1 / sqrt(0.36) = 5 / 3, where it is 10 / 9.
  const Camera camera(CameraModel::kSimpleRadial, 640, 480, {450, 320, 240, -0.12});
  EXPECT_TRUE(camera.project(Eigen::Vector3d(5.0 / 3 - 1e-6, 0, 1)).has_value());
  EXPECT_FALSE(camera.project(Eigen::Vector3d(5.0 / 3 + 1e-6, 0, 1)).has_value());
  EXPECT_TRUE(camera.unproject(Eigen::Vector2d(320 + 500 - 1e-3, 240)).has_value());
  EXPECT_FALSE(camera.unproject(Eigen::Vector2d(320 + 500 + 1e-3, 240)).has_value());
}

TEST(CameraValidity, EquirectangularPolesHaveNoColumn) {
  const Camera camera(CameraModel::kEquirectangular, 400, 200, {400, 200});
  EXPECT_FALSE(camera.project(Eigen::Vector3d(0, 1, 0)).has_value());
  EXPECT_FALSE(camera.project(Eigen::Vector3d(0, -3, 0)).has_value());
  const std::optional<Eigen::Vector2d> near_pole = camera.project(Eigen::Vector3d(1e-6, -1, 0));
  ASSERT_TRUE(near_pole.has_value());
  EXPECT_NEAR(near_pole->y(), -0.5, 1e-3);
  EXPECT_NEAR(near_pole->x(), 299.5, 1e-9);
  EXPECT_TRUE(camera.unproject(Eigen::Vector2d(17, -0.5))->isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
  EXPECT_FALSE(camera.unproject(Eigen::Vector2d(17, -0.6)).has_value());
  EXPECT_FALSE(camera.unproject(Eigen::Vector2d(400, 20)).has_value());
}

TEST(CameraValidity, EquirectangularSeamJoinsTheTwoSides) {
  const Camera camera(CameraModel::kEquirectangular, 400, 200, {400, 200});
  const Eigen::Vector3d left = *camera.unproject(Eigen::Vector2d(-0.5, 60));
  const Eigen::Vector3d right = *camera.unproject(Eigen::Vector2d(399.5, 60));
  EXPECT_TRUE(left.isApprox(right, 1e-12));
  EXPECT_LT(left.z(), 0.0);
}

// ---- field of view ----

TEST(CameraView, LargestAngle) {
  // corner of a 101 x 101 pinhole with f = 50: atan(sqrt(2))
  EXPECT_NEAR(Camera(CameraModel::kSimplePinhole, 101, 101, {50, 50, 50}).max_view_angle(), std::atan(std::sqrt(2.0)),
              1e-12);
  // equidistant fisheye, 1 rad = 100 px, image corner at 141.4 px
  EXPECT_NEAR(Camera(CameraModel::kOpenCvFisheye, 201, 201, {100, 100, 100, 100, 0, 0, 0, 0}).max_view_angle(),
              std::sqrt(2.0), 1e-9);
  // corners beyond 180 degrees from the axis
  EXPECT_NEAR(Camera(CameraModel::kOpenCvFisheye, 801, 801, {100, 100, 400, 400, 0, 0, 0, 0}).max_view_angle(), M_PI,
              1e-6);
  EXPECT_EQ(Camera(CameraModel::kEquirectangular, 400, 200, {400, 200}).max_view_angle(), M_PI);
}

TEST(CameraView, PixelsPerRadian) {
  EXPECT_EQ(Camera(CameraModel::kSimpleRadial, 640, 480, {450, 320, 240, -0.12}).pixels_per_radian(), 450);
  EXPECT_EQ(Camera(CameraModel::kPinhole, 640, 480, {400, 500, 320, 240}).pixels_per_radian(), 450);
  EXPECT_NEAR(Camera(CameraModel::kEquirectangular, 400, 200, {400, 200}).pixels_per_radian(), 200 / M_PI, 1e-12);
}

// ---- names and bad input ----

TEST(CameraNames, RoundTripAndColmapIds) {
  const std::vector<std::pair<std::string, int>> expected = {
      {"SIMPLE_PINHOLE", 0}, {"PINHOLE", 1},        {"SIMPLE_RADIAL", 2}, {"RADIAL", 3},
      {"OPENCV", 4},         {"OPENCV_FISHEYE", 5}, {"FULL_OPENCV", 6},   {"EQUIRECTANGULAR", 17}};
  for (const auto& [name, id] : expected) {
    const std::optional<CameraModel> model = camera_model_from_name(name);
    ASSERT_TRUE(model.has_value()) << name;
    EXPECT_EQ(camera_model_name(*model), name);
    EXPECT_EQ(camera_model_colmap_id(*model), id);
    EXPECT_EQ(camera_model_from_colmap_id(id), model);
  }
  EXPECT_FALSE(camera_model_from_name("opencv").has_value());
  EXPECT_FALSE(camera_model_from_name("FOV").has_value());
  EXPECT_FALSE(camera_model_from_colmap_id(7).has_value());
  EXPECT_FALSE(camera_model_from_colmap_id(-1).has_value());
}

TEST(CameraErrors, OneLineThatNamesTheFieldAndTheValue) {
  EXPECT_EQ(error_of(CameraModel::kOpenCv, 640, 480, {500, 500, 320, 240}),
            "camera OPENCV: expected 8 parameters (fx, fy, cx, cy, k1, k2, p1, p2), got 4");
  EXPECT_EQ(error_of(CameraModel::kPinhole, 640, 480, {500, 0, 320, 240}),
            "camera PINHOLE: focal length must be positive, got 0");
  EXPECT_EQ(error_of(CameraModel::kSimplePinhole, 640, 480, {-500, 320, 240}),
            "camera SIMPLE_PINHOLE: focal length must be positive, got -500");
  EXPECT_EQ(error_of(CameraModel::kPinhole, 640, 480, {500, 500, kNan, 240}), "camera PINHOLE: parameter 3 is nan");
  EXPECT_EQ(error_of(CameraModel::kPinhole, 0, 480, {500, 500, 320, 240}),
            "camera PINHOLE: size must be positive, got 0x480");
  EXPECT_THAT(error_of(CameraModel::kEquirectangular, 400, 200, {400, 0}), HasSubstr("panorama size"));
  EXPECT_EQ(error_of(CameraModel::kPinhole, 640, 480, {500, 500, 320, 240}), "");
}

TEST(CameraErrors, DefaultCameraSeesNothing) {
  EXPECT_FALSE(Camera().project(Eigen::Vector3d(0, 0, 1)).has_value());
  EXPECT_FALSE(Camera().unproject(Eigen::Vector2d(0, 0)).has_value());
}

TEST(Camera, ManyPointsProjectAsOneByOne) {
  constexpr size_t kCount = 500;
  for (const auto& [name, camera] : all_cameras()) {
    Random random(11);
    std::vector<float> x(kCount), y(kCount), z(kCount), column(kCount), row(kCount);
    for (size_t i = 0; i < kCount; ++i) {
      x[i] = static_cast<float>(random.normal());
      y[i] = static_cast<float>(random.normal());
      z[i] = static_cast<float>(random.normal());
    }
    z[0] = 0.0f;
    camera.project(kCount, x.data(), y.data(), z.data(), column.data(), row.data());
    for (size_t i = 0; i < kCount; ++i) {
      const auto pixel = camera.project(Eigen::Vector3d(x[i], y[i], z[i]));
      ASSERT_EQ(pixel.has_value(), !std::isnan(column[i])) << name;
      ASSERT_EQ(pixel.has_value(), !std::isnan(row[i])) << name;
      if (!pixel) continue;
      const double tolerance_px = camera.in_image(*pixel) ? 1e-3 : 1e-5 * (1e3 + pixel->norm());
      ASSERT_NEAR(column[i], pixel->x(), tolerance_px) << name;
      ASSERT_NEAR(row[i], pixel->y(), tolerance_px) << name;
    }
  }
}

TEST(Camera, ManyPointsOfACameraThatIsNotSet) {
  const float one = 1.0f;
  float column = 0.0f, row = 0.0f;
  Camera().project(1, &one, &one, &one, &column, &row);
  EXPECT_TRUE(std::isnan(column));
  EXPECT_TRUE(std::isnan(row));
}

}  // namespace
}  // namespace cpplus
