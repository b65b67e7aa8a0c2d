#pragma once

#include "cpplus/geometry/camera_models/perspective.h"

namespace cpplus::camera_models {

/// OPENCV: g(s) = 1 + k1 s + k2 s^2 and tangential p1, p2 (PerspectiveModel has the rest of the equations).
///
/// Parameters: fx, fy, cx, cy, k1, k2, p1, p2. Valid up to the first zero of d (r g) / d r = 1 + 3 k1 s + 5 k2 s^2, or
/// the smallest radius at which the tangential part folds the plane.
struct OpenCv : PerspectiveModel<OpenCv> {
  static constexpr const char* kName = "OPENCV";
  static constexpr int kColmapId = 4;
  static constexpr int kNumParams = 8;
  static constexpr const char* kParams = "fx, fy, cx, cy, k1, k2, p1, p2";
  static constexpr int kNumFocals = 2;
  static constexpr int kTangential = 6;

  static double radial_factor(const double* p, double s, double* dg_ds) {
    *dg_ds = p[4] + 2.0 * p[5] * s;
    return 1.0 + s * (p[4] + s * p[5]);
  }

  static RadialCoefficients radial_coefficients(const double* p) { return {p[4], p[5]}; }

  static std::vector<std::vector<double>> slope_polynomials(const double* p) { return {{1.0, 3.0 * p[4], 5.0 * p[5]}}; }
};

}  // namespace cpplus::camera_models
