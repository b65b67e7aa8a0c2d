#include "cpplus/geometry/tangent_box.h"

namespace cpplus {

TangentBox tangent_box(const Camera& camera) {
  constexpr int kSteps = 32;
  constexpr float kMargin = 0.01f;  // for what bulges between the steps
  constexpr double kMinCos = 0.2;
  TangentBox box;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = static_cast<double>(camera.width()) * i / kSteps - 0.5;
    const double y = static_cast<double>(camera.height()) * i / kSteps - 0.5;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, -0.5), Eigen::Vector2d(x, camera.height() - 0.5),
                                         Eigen::Vector2d(-0.5, y), Eigen::Vector2d(camera.width() - 0.5, y)}) {
      const auto bearing = camera.unproject(pixel);
      if (!bearing || bearing->z() < kMinCos) return {};
      const Eigen::Array2f tangents = (bearing->head<2>() / bearing->z()).cast<float>().array();
      box.low = box.limited ? box.low.min(tangents) : tangents;
      box.high = box.limited ? box.high.max(tangents) : tangents;
      box.limited = true;
    }
  }
  const Eigen::Array2f margin = kMargin * (box.high - box.low);
  box.low -= margin;
  box.high += margin;
  return box;
}

}  // namespace cpplus
