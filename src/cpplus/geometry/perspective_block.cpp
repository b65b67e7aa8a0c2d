#include "cpplus/geometry/perspective_block.h"

#include <limits>

#include "cpplus/core/vector_clones.h"

namespace cpplus {

CPPLUS_VECTOR_CLONES void project_block(const PerspectiveCoefficients& coefficients, size_t count,
                                        const float* __restrict x, const float* __restrict y, const float* __restrict z,
                                        float* __restrict column, float* __restrict row) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto [k1, k2, k3, k4, k5, k6] = coefficients.radial;
  const auto [p1, p2] = coefficients.tangential;
  const auto [focal_x, focal_y] = coefficients.focal;
  const auto [center_x, center_y] = coefficients.center;
  const float min_depth = coefficients.min_depth;
  const float max_squared_radius = coefficients.max_squared_radius;
  for (size_t i = 0; i < count; ++i) {
    const float inverse_depth = 1.0f / z[i];
    const float a = x[i] * inverse_depth;
    const float b = y[i] * inverse_depth;
    const float s = a * a + b * b;
    const float g = (1.0f + s * (k1 + s * (k2 + s * k3))) / (1.0f + s * (k4 + s * (k5 + s * k6)));
    const float u = a * g + 2.0f * p1 * a * b + p2 * (s + 2.0f * a * a);
    const float v = b * g + p1 * (s + 2.0f * b * b) + 2.0f * p2 * a * b;
    const bool valid = (z[i] > min_depth) & (s < max_squared_radius);
    column[i] = valid ? focal_x * u + center_x : kNan;
    row[i] = valid ? focal_y * v + center_y : kNan;
  }
}

}  // namespace cpplus
