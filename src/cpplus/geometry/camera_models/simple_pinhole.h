#pragma once

#include "cpplus/geometry/camera_models/perspective.h"

namespace cpplus::camera_models {

/// SIMPLE_PINHOLE: column = f X / Z + cx, row = f Y / Z + cy.
///
/// Parameters: f, cx, cy. Valid for every Z > 0.
struct SimplePinhole : PerspectiveModel<SimplePinhole> {
  static constexpr const char* kName = "SIMPLE_PINHOLE";
  static constexpr int kColmapId = 0;
  static constexpr int kNumParams = 3;
  static constexpr const char* kParams = "f, cx, cy";
  static constexpr int kNumFocals = 1;
  static constexpr int kTangential = -1;

  static double radial_factor(const double*, double, double* dg_ds) {
    *dg_ds = 0.0;
    return 1.0;
  }

  static RadialCoefficients radial_coefficients(const double*) { return {}; }

  static std::vector<std::vector<double>> slope_polynomials(const double*) { return {}; }
};

}  // namespace cpplus::camera_models
