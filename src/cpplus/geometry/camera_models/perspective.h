#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "cpplus/geometry/camera_models/monotonic_range.h"
#include "cpplus/geometry/perspective_block.h"

namespace cpplus::camera_models {

/// All radial factors are g(s) = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3).
using RadialCoefficients = std::array<double, 6>;

/// What the models with an image plane share. With x = X / Z, y = Y / Z, s = r^2 = x^2 + y^2:
///
///   u = x g(s) + 2 p1 x y + p2 (s + 2 x^2)         column = fx u + cx
///   v = y g(s) + p1 (s + 2 y^2) + 2 p2 x y         row    = fy v + cy
///
/// g is the radial factor; p1, p2 (tangential) are zero in the models that lack them. A point is valid for Z > 0 and
/// r < max_radius: within it r g(r^2) rises and the map (x, y) -> (u, v) does not fold, so it has an inverse.
///
/// `Model` gives kNumFocals (1 or 2; then cx, cy, then the distortion), kTangential (index of p1, or -1),
/// radial_factor(params, s, &dg_ds), radial_coefficients(params), and slope_polynomials(params): polynomials in s whose
/// first sign change ends the monotonic range of r g(r^2).
template <typename Model>
struct PerspectiveModel {
  static constexpr double kMinDepth = 1e-9;  // metres

  static double focal_x(const double* p) { return p[0]; }
  static double focal_y(const double* p) { return p[Model::kNumFocals - 1]; }
  static double center_x(const double* p) { return p[Model::kNumFocals]; }
  static double center_y(const double* p) { return p[Model::kNumFocals + 1]; }

  /// (x, y) -> (u, v); jacobian (row-major d(u, v) / d(x, y)) may be null.
  static void distort(const double* p, double x, double y, double* u, double* v, double* jacobian) {
    const double s = x * x + y * y;
    double dg = 0.0;
    const double g = Model::radial_factor(p, s, &dg);
    *u = x * g;
    *v = y * g;
    if (jacobian) {
      jacobian[0] = g + 2.0 * x * x * dg;
      jacobian[1] = jacobian[2] = 2.0 * x * y * dg;
      jacobian[3] = g + 2.0 * y * y * dg;
    }
    if constexpr (Model::kTangential >= 0) {
      const double p1 = p[Model::kTangential];
      const double p2 = p[Model::kTangential + 1];
      *u += 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x);
      *v += p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y;
      if (jacobian) {
        jacobian[0] += 2.0 * p1 * y + 6.0 * p2 * x;
        jacobian[1] += 2.0 * p1 * x + 2.0 * p2 * y;
        jacobian[2] += 2.0 * p1 * x + 2.0 * p2 * y;
        jacobian[3] += 6.0 * p1 * y + 2.0 * p2 * x;
      }
    }
  }

  /// d_pixel_d_point may be null.
  static bool project(const double* p, double max_radius, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                      Eigen::Matrix<double, 2, 3>* d_pixel_d_point) {
    if (!(point.z() > kMinDepth)) return false;
    const double inverse_depth = 1.0 / point.z();
    const double x = point.x() * inverse_depth;
    const double y = point.y() * inverse_depth;
    if (!(x * x + y * y < max_radius * max_radius)) return false;
    double u = 0.0;
    double v = 0.0;
    double j[4];
    distort(p, x, y, &u, &v, d_pixel_d_point ? j : nullptr);
    *pixel << focal_x(p) * u + center_x(p), focal_y(p) * v + center_y(p);
    if (d_pixel_d_point) {
      const double a = focal_x(p) * inverse_depth;
      const double b = focal_y(p) * inverse_depth;
      *d_pixel_d_point << a * j[0], a * j[1], -a * (j[0] * x + j[1] * y),  //
          b * j[2], b * j[3], -b * (j[2] * x + j[3] * y);
    }
    return true;
  }

  static PerspectiveCoefficients coefficients(const double* p, double max_radius) {
    PerspectiveCoefficients c;
    c.focal = {static_cast<float>(focal_x(p)), static_cast<float>(focal_y(p))};
    c.center = {static_cast<float>(center_x(p)), static_cast<float>(center_y(p))};
    const RadialCoefficients radial = Model::radial_coefficients(p);
    for (size_t i = 0; i < radial.size(); ++i) c.radial[i] = static_cast<float>(radial[i]);
    if constexpr (Model::kTangential >= 0) {
      c.tangential = {static_cast<float>(p[Model::kTangential]), static_cast<float>(p[Model::kTangential + 1])};
    }
    c.min_depth = static_cast<float>(kMinDepth);
    c.max_squared_radius = static_cast<float>(max_radius * max_radius);
    return c;
  }

  /// Radial part by a bracketed Newton iteration, which cannot miss; then both coordinates by Newton's method, since
  /// the tangential part is small.
  static std::optional<Eigen::Vector3d> unproject(const double* p, double max_radius, const Eigen::Vector2d& pixel) {
    const double u = (pixel.x() - center_x(p)) / focal_x(p);
    const double v = (pixel.y() - center_y(p)) / focal_y(p);
    const double distorted = std::hypot(u, v);
    if (!std::isfinite(distorted)) return std::nullopt;
    double r = invert_monotonic(distorted, max_radius, [p](double radius, double* slope) {
      double dg = 0.0;
      const double g = Model::radial_factor(p, radius * radius, &dg);
      *slope = g + 2.0 * radius * radius * dg;
      return radius * g;
    });
    if constexpr (Model::kTangential >= 0) {
      if (std::isnan(r) && std::isfinite(max_radius)) r = 0.99 * max_radius;  // within the tangential part of the limit
    }
    if (std::isnan(r)) return std::nullopt;
    double x = distorted > 0.0 ? u * r / distorted : 0.0;
    double y = distorted > 0.0 ? v * r / distorted : 0.0;
    if constexpr (Model::kTangential >= 0) {
      if (!refine_inverse(p, u, v, &x, &y)) return std::nullopt;
    }
    if (!(x * x + y * y < max_radius * max_radius)) return std::nullopt;
    return Eigen::Vector3d(x, y, 1.0).normalized();
  }

  /// The radius below which a point is valid in all directions (see above), a little inside of the exact limit, where
  /// the inverse is singular.
  static double max_radius(const double* p) {
    double radius = std::numeric_limits<double>::infinity();
    for (const std::vector<double>& polynomial : Model::slope_polynomials(p)) {
      radius = std::min(radius, std::sqrt(first_positive_sign_change(polynomial)));
    }
    if constexpr (Model::kTangential >= 0) {
      if (p[Model::kTangential] != 0.0 || p[Model::kTangential + 1] != 0.0) radius = first_fold(p, radius);
    }
    return radius * (1.0 - 1e-9);
  }

 private:
  static bool refine_inverse(const double* p, double u, double v, double* x, double* y) {
    for (int i = 0; i < 30; ++i) {
      double u_now = 0.0;
      double v_now = 0.0;
      double j[4];
      distort(p, *x, *y, &u_now, &v_now, j);
      const double du = u - u_now;
      const double dv = v - v_now;
      const double determinant = j[0] * j[3] - j[1] * j[2];
      if (!(determinant > 0.0)) return false;
      const double dx = (j[3] * du - j[1] * dv) / determinant;
      const double dy = (j[0] * dv - j[2] * du) / determinant;
      *x += dx;
      *y += dy;
      if (std::abs(dx) + std::abs(dy) <= 1e-14 * (1.0 + std::abs(*x) + std::abs(*y))) return true;
    }
    return false;
  }

  /// Smallest radius up to `limit` where the Jacobian of distort() loses its rank in some direction.
  static double first_fold(const double* p, double limit) {
    constexpr int kDirections = 48;
    constexpr double kGrowth = 1.02;
    constexpr double kFarthest = 1e3;  // 89.94 degrees from the axis
    std::array<Eigen::Vector2d, kDirections> directions;
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2.0 * M_PI * i / kDirections;
      directions[i] << std::cos(angle), std::sin(angle);
    }
    const auto folds = [&](double r) {
      for (const Eigen::Vector2d& direction : directions) {
        double u = 0.0;
        double v = 0.0;
        double j[4];
        distort(p, r * direction.x(), r * direction.y(), &u, &v, j);
        if (!(j[0] * j[3] - j[1] * j[2] > 0.0)) return true;
      }
      return false;
    };
    double inside = 0.0;
    for (double r = 0.05; inside < limit && inside < kFarthest; r *= kGrowth) {
      const double outside = std::min(r, limit);
      if (folds(outside)) {
        double high = outside;
        for (int i = 0; i < 40; ++i) {
          const double middle = 0.5 * (inside + high);
          (folds(middle) ? high : inside) = middle;
        }
        return inside;
      }
      inside = outside;
    }
    return limit;
  }
};

}  // namespace cpplus::camera_models
