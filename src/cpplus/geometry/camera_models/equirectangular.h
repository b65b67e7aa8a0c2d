#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

namespace cpplus::camera_models {

/// EQUIRECTANGULAR: with h = sqrt(X^2 + Z^2), longitude = atan2(X, Z) (0 ahead, positive to the right) and
/// latitude = atan2(Y, h) (positive down):
///
///   column = (longitude / 2 pi + 1/2) w - 1/2          row = (latitude / pi + 1/2) h_image - 1/2
///
/// Parameters: w, h_image, the size of the whole panorama in pixels. The -1/2 makes the centre of the top-left pixel
/// (0, 0). Valid in all directions but the poles (X = Z = 0), where the column is not defined; the seam is straight
/// behind, at columns -1/2 and w - 1/2.
struct Equirectangular {
  static constexpr const char* kName = "EQUIRECTANGULAR";
  static constexpr int kColmapId = 17;
  static constexpr int kNumParams = 2;
  static constexpr const char* kParams = "w, h";
  static constexpr int kNumFocals = 2;  // in this place: both have to be positive

  static bool project(const double* p, double, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                      Eigen::Matrix<double, 2, 3>* d_pixel_d_point) {
    const double x = point.x();
    const double y = point.y();
    const double z = point.z();
    const double h2 = x * x + z * z;
    const double n2 = h2 + y * y;
    if (!std::isfinite(n2) || !(h2 > 1e-18 * n2)) return false;
    const double h = std::sqrt(h2);
    const double columns_per_radian = p[0] / (2.0 * M_PI);
    const double rows_per_radian = p[1] / M_PI;
    *pixel << std::atan2(x, z) * columns_per_radian + 0.5 * p[0] - 0.5,
        std::atan2(y, h) * rows_per_radian + 0.5 * p[1] - 0.5;
    if (d_pixel_d_point) {
      const double a = columns_per_radian / h2;
      const double b = rows_per_radian / n2;
      *d_pixel_d_point << a * z, 0.0, -a * x, -b * x * y / h, b * h, -b * z * y / h;
    }
    return true;
  }

  static std::optional<Eigen::Vector3d> unproject(const double* p, double, const Eigen::Vector2d& pixel) {
    const double across = (pixel.x() + 0.5) / p[0];
    const double down = (pixel.y() + 0.5) / p[1];
    if (!(across >= 0.0 && across <= 1.0 && down >= 0.0 && down <= 1.0)) return std::nullopt;
    const double longitude = 2.0 * M_PI * (across - 0.5);
    const double latitude = M_PI * (down - 0.5);
    const double h = std::cos(latitude);
    return Eigen::Vector3d(h * std::sin(longitude), std::sin(latitude), h * std::cos(longitude));
  }

  static double max_radius(const double*) { return M_PI; }
};

}  // namespace cpplus::camera_models
