#pragma once

#include <array>
#include <cstddef>

namespace cpplus {

/// What projects points in the models with an image plane (camera_models/perspective.h), in single precision.
struct PerspectiveCoefficients {
  std::array<float, 2> focal{};
  std::array<float, 2> center{};
  std::array<float, 6> radial{};      // k1 ... k6
  std::array<float, 2> tangential{};  // p1, p2
  float min_depth = 0.0f;
  float max_squared_radius = 0.0f;
};

/// Projects points (camera frame, one array a coordinate) to pixels; NaN where the model does not hold. A loop that
/// becomes vector instructions.
void project_block(const PerspectiveCoefficients& coefficients, size_t count, const float* x, const float* y,
                   const float* z, float* column, float* row);

}  // namespace cpplus
