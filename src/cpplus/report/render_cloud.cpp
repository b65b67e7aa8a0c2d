#include "cpplus/report/render_cloud.h"

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {

namespace {

constexpr Rgb kBackground = {10, 10, 40};
constexpr int kMaxRadiusPx = 7;

}  // namespace

CloudRendering render_colored_cloud(const PointCloud& cloud, const Camera& camera, const Rigid3& camera_from_map,
                                    double point_size_m) {
  if (cloud.colors.size() != cloud.size()) throw Error("a cloud without colours cannot be rendered");
  CloudRendering rendering{ColorImage(camera.width(), camera.height(), kBackground),
                           Image<uint8_t>(camera.width(), camera.height(), 0)};
  RangeImage ranges(camera.width(), camera.height());
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d x_in_camera = camera_from_map * cloud.point(i);
    const auto pixel = camera.project(x_in_camera);
    if (!pixel || !camera.in_image(*pixel, -kMaxRadiusPx)) continue;
    const float range = static_cast<float>(x_in_camera.norm());
    const double half_size_px = 0.5 * point_size_m * camera.pixels_per_radian() / static_cast<double>(range);
    const int radius = static_cast<int>(std::lround(std::min(half_size_px, double{kMaxRadiusPx})));
    const uint8_t colored = cloud.num_views.empty() || cloud.num_views[i] > 0 ? 1 : 0;
    const Eigen::Vector2i center = (pixel->array() + 0.5).floor().cast<int>();
    for (int y = center.y() - radius; y <= center.y() + radius; ++y) {
      for (int x = center.x() - radius; x <= center.x() + radius; ++x) {
        if (!rendering.picture.contains(x, y)) continue;
        float& nearest = ranges.at(x, y);
        if (nearest != 0.0f && nearest <= range) continue;
        nearest = range;
        rendering.picture.at(x, y) = cloud.colors[i];
        rendering.colored.at(x, y) = colored;
      }
    }
  }
  return rendering;
}

ColorImage render_cloud(const PointCloud& cloud, const Camera& camera, const Rigid3& camera_from_map,
                        double point_size_m) {
  return render_colored_cloud(cloud, camera, camera_from_map, point_size_m).picture;
}

ColorImage side_by_side(const ColorImage& left, const ColorImage& right) {
  if (left.height != right.height) throw Error("pictures of different heights do not go side by side");
  ColorImage both(left.width + right.width, left.height);
  for (int y = 0; y < both.height; ++y) {
    for (int x = 0; x < both.width; ++x) {
      both.at(x, y) = x < left.width ? left.at(x, y) : right.at(x - left.width, y);
    }
  }
  return both;
}

}  // namespace cpplus
