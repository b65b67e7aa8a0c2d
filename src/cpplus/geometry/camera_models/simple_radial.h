#pragma once

#include "cpplus/geometry/camera_models/perspective.h"

namespace cpplus::camera_models {

/// SIMPLE_RADIAL: g(s) = 1 + k s, one focal length (PerspectiveModel has the rest of the equations).
///
/// Parameters: f, cx, cy, k. For k < 0 the distorted radius r + k r^3 falls beyond r = 1 / sqrt(-3 k): points farther
/// from the axis would come back into the image and are not valid.
struct SimpleRadial : PerspectiveModel<SimpleRadial> {
  static constexpr const char* kName = "SIMPLE_RADIAL";
  static constexpr int kColmapId = 2;
  static constexpr int kNumParams = 4;
  static constexpr const char* kParams = "f, cx, cy, k";
  static constexpr int kNumFocals = 1;
  static constexpr int kTangential = -1;

  static double radial_factor(const double* p, double s, double* dg_ds) {
    *dg_ds = p[3];
    return 1.0 + p[3] * s;
  }

  static RadialCoefficients radial_coefficients(const double* p) { return {p[3]}; }

  static std::vector<std::vector<double>> slope_polynomials(const double* p) { return {{1.0, 3.0 * p[3]}}; }
};

}  // namespace cpplus::camera_models
