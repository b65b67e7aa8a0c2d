#pragma once

#include "cpplus/geometry/camera_models/perspective.h"

namespace cpplus::camera_models {

/// PINHOLE: column = fx X / Z + cx, row = fy Y / Z + cy.
///
/// Parameters: fx, fy, cx, cy. Valid for every Z > 0.
struct Pinhole : PerspectiveModel<Pinhole> {
  static constexpr const char* kName = "PINHOLE";
  static constexpr int kColmapId = 1;
  static constexpr int kNumParams = 4;
  static constexpr const char* kParams = "fx, fy, cx, cy";
  static constexpr int kNumFocals = 2;
  static constexpr int kTangential = -1;

  static double radial_factor(const double*, double, double* dg_ds) {
    *dg_ds = 0.0;
    return 1.0;
  }

  static RadialCoefficients radial_coefficients(const double*) { return {}; }

  static std::vector<std::vector<double>> slope_polynomials(const double*) { return {}; }
};

}  // namespace cpplus::camera_models
