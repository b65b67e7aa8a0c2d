#pragma once

#include "cpplus/geometry/camera_models/perspective.h"

namespace cpplus::camera_models {

/// FULL_OPENCV: g(s) = N / D with N = 1 + k1 s + k2 s^2 + k3 s^3, D = 1 + k4 s + k5 s^2 + k6 s^3, and tangential p1, p2
/// (PerspectiveModel has the rest of the equations).
///
/// Parameters: fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6. Valid up to the first of: a pole D = 0, a zero of the
/// numerator of d (r g) / d r, which is N D + 2 s (N' D - N D'), a fold by the tangential part.
struct FullOpenCv : PerspectiveModel<FullOpenCv> {
  static constexpr const char* kName = "FULL_OPENCV";
  static constexpr int kColmapId = 6;
  static constexpr int kNumParams = 12;
  static constexpr const char* kParams = "fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6";
  static constexpr int kNumFocals = 2;
  static constexpr int kTangential = 6;

  static double radial_factor(const double* p, double s, double* dg_ds) {
    const double n = 1.0 + s * (p[4] + s * (p[5] + s * p[8]));
    const double d = 1.0 + s * (p[9] + s * (p[10] + s * p[11]));
    const double dn = p[4] + s * (2.0 * p[5] + s * 3.0 * p[8]);
    const double dd = p[9] + s * (2.0 * p[10] + s * 3.0 * p[11]);
    const double g = n / d;
    *dg_ds = (dn - g * dd) / d;
    return g;
  }

  static RadialCoefficients radial_coefficients(const double* p) { return {p[4], p[5], p[8], p[9], p[10], p[11]}; }

  static std::vector<std::vector<double>> slope_polynomials(const double* p) {
    const std::vector<double> n = {1.0, p[4], p[5], p[8]};
    const std::vector<double> d = {1.0, p[9], p[10], p[11]};
    std::vector<double> slope(7, 0.0);
    for (size_t i = 0; i < 4; ++i) {
      for (size_t j = 0; j < 4; ++j) {
        slope[i + j] += (1.0 + 2.0 * static_cast<double>(i) - 2.0 * static_cast<double>(j)) * n[i] * d[j];
      }
    }
    return {slope, d};
  }
};

}  // namespace cpplus::camera_models
