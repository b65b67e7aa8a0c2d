#include "cpplus/geometry/scaled_camera.h"

#include <cmath>

namespace cpplus {

Camera scaled_camera(const Camera& camera, double scale) {
  if (scale == 1.0) return camera;
  const int width = static_cast<int>(std::lround(scale * camera.width()));
  const int height = static_cast<int>(std::lround(scale * camera.height()));
  std::vector<double> params = camera.params();
  const std::optional<size_t> principal_point = camera_model_principal_point_index(camera.model());
  if (!principal_point) {
    return Camera(camera.model(), width, height, {static_cast<double>(width), static_cast<double>(height)});
  }
  for (size_t i = 0; i < *principal_point; ++i) params[i] *= scale;  // focal lengths come first in every model
  // Pixel centres are whole numbers, so the borders are at -0.5.
  for (size_t i = *principal_point; i < *principal_point + 2; ++i) params[i] = scale * (params[i] + 0.5) - 0.5;
  return Camera(camera.model(), width, height, params);
}

}  // namespace cpplus
