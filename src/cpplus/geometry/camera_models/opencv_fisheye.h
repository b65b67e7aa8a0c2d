#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "cpplus/geometry/camera_models/monotonic_range.h"

namespace cpplus::camera_models {

/// OPENCV_FISHEYE (Kannala & Brandt 2006): with h = sqrt(X^2 + Y^2), the angle from the axis t = atan2(h, Z) and
/// t_d = t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8):
///
///   column = fx t_d X / h + cx          row = fy t_d Y / h + cy
///
/// Parameters: fx, fy, cx, cy, k1, k2, k3, k4. Points beside and behind the camera (t >= 90 degrees) are valid up to
/// the first zero of d t_d / d t, at most 180 degrees; the radial variable of the limit is t.
struct OpenCvFisheye {
  static constexpr const char* kName = "OPENCV_FISHEYE";
  static constexpr int kColmapId = 5;
  static constexpr int kNumParams = 8;
  static constexpr const char* kParams = "fx, fy, cx, cy, k1, k2, k3, k4";
  static constexpr int kNumFocals = 2;

  static double distorted_angle(const double* p, double t, double* slope) {
    const double s = t * t;
    *slope = 1.0 + s * (3.0 * p[4] + s * (5.0 * p[5] + s * (7.0 * p[6] + s * 9.0 * p[7])));
    return t * (1.0 + s * (p[4] + s * (p[5] + s * (p[6] + s * p[7]))));
  }

  static bool project(const double* p, double max_angle, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                      Eigen::Matrix<double, 2, 3>* d_pixel_d_point) {
    const double x = point.x();
    const double y = point.y();
    const double z = point.z();
    const double h2 = x * x + y * y;
    const double n2 = h2 + z * z;
    if (!(n2 > 0.0) || !std::isfinite(n2)) return false;
    const double h = std::sqrt(h2);
    if (h < 1e-9 * z) {  // on the axis: t_d = t = h / Z to within rounding
      *pixel << p[0] * x / z + p[2], p[1] * y / z + p[3];
      if (d_pixel_d_point) *d_pixel_d_point << p[0] / z, 0.0, -p[0] * x / (z * z), 0.0, p[1] / z, -p[1] * y / (z * z);
      return true;
    }
    const double t = std::atan2(h, z);
    if (!(t < max_angle)) return false;
    double slope = 0.0;
    const double scale = distorted_angle(p, t, &slope) / h;  // t_d / h
    *pixel << p[0] * scale * x + p[2], p[1] * scale * y + p[3];
    if (d_pixel_d_point) {
      // d scale / d(X, Y) = radial * (X, Y), from d t / d h = Z / n^2; d scale / d Z = depth, from d t / d Z = -h /
      // n^2.
      const double radial = (slope * z / n2 - scale) / h2;
      const double depth = -slope / n2;
      *d_pixel_d_point << p[0] * (scale + radial * x * x), p[0] * radial * x * y, p[0] * depth * x,
          p[1] * radial * x * y, p[1] * (scale + radial * y * y), p[1] * depth * y;
    }
    return true;
  }

  static std::optional<Eigen::Vector3d> unproject(const double* p, double max_angle, const Eigen::Vector2d& pixel) {
    const double u = (pixel.x() - p[2]) / p[0];
    const double v = (pixel.y() - p[3]) / p[1];
    const double distorted = std::hypot(u, v);
    const double t = invert_monotonic(distorted, max_angle,
                                      [p](double angle, double* slope) { return distorted_angle(p, angle, slope); });
    if (!(t < max_angle)) return std::nullopt;
    if (distorted == 0.0) return Eigen::Vector3d::UnitZ();
    const double scale = std::sin(t) / distorted;
    return Eigen::Vector3d(scale * u, scale * v, std::cos(t));
  }

  static double max_radius(const double* p) {
    const double limit = first_positive_sign_change({1.0, 3.0 * p[4], 5.0 * p[5], 7.0 * p[6], 9.0 * p[7]});
    return std::min(M_PI, std::sqrt(limit)) * (1.0 - 1e-9);
  }
};

}  // namespace cpplus::camera_models
