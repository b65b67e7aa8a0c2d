#pragma once

#include "cpplus/geometry/camera_models/perspective.h"

namespace cpplus::camera_models {

/// RADIAL: g(s) = 1 + k1 s + k2 s^2, one focal length (PerspectiveModel has the rest of the equations).
///
/// Parameters: f, cx, cy, k1, k2. Valid up to the first zero of d (r g) / d r = 1 + 3 k1 s + 5 k2 s^2.
struct Radial : PerspectiveModel<Radial> {
  static constexpr const char* kName = "RADIAL";
  static constexpr int kColmapId = 3;
  static constexpr int kNumParams = 5;
  static constexpr const char* kParams = "f, cx, cy, k1, k2";
  static constexpr int kNumFocals = 1;
  static constexpr int kTangential = -1;

  static double radial_factor(const double* p, double s, double* dg_ds) {
    *dg_ds = p[3] + 2.0 * p[4] * s;
    return 1.0 + s * (p[3] + s * p[4]);
  }

  static RadialCoefficients radial_coefficients(const double* p) { return {p[3], p[4]}; }

  static std::vector<std::vector<double>> slope_polynomials(const double* p) { return {{1.0, 3.0 * p[3], 5.0 * p[4]}}; }
};

}  // namespace cpplus::camera_models
