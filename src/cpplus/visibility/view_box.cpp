#include "cpplus/visibility/view_box.h"

namespace cpplus {

ViewBox::ViewBox(const Camera& camera) {
  constexpr int kSteps = 32;
  constexpr float kMargin = 0.01f;  // for what bulges between the steps
  constexpr double kMinCos = 0.2;
  Eigen::Array2f low, high;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = static_cast<double>(camera.width()) * i / kSteps - 0.5;
    const double y = static_cast<double>(camera.height()) * i / kSteps - 0.5;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, -0.5), Eigen::Vector2d(x, camera.height() - 0.5),
                                         Eigen::Vector2d(-0.5, y), Eigen::Vector2d(camera.width() - 0.5, y)}) {
      const auto bearing = camera.unproject(pixel);
      if (!bearing || bearing->z() < kMinCos) return;
      const Eigen::Array2f tangents = (bearing->head<2>() / bearing->z()).cast<float>().array();
      const bool first = i == 0 && pixel.y() == -0.5 && pixel.x() == -0.5;
      low = first ? tangents : low.min(tangents);
      high = first ? tangents : high.max(tangents);
    }
  }
  limited_ = true;
  const Eigen::Array2f margin = kMargin * (high - low);
  low_ = low - margin;
  high_ = high + margin;
}

}  // namespace cpplus
