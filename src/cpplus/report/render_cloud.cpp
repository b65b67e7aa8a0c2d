#include "cpplus/report/render_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "cpplus/core/error.h"

namespace cpplus {

namespace {

constexpr Rgb kBackground = {10, 10, 40};
constexpr int kMaxRadiusPx = 7;
/// Points no farther than this behind the nearest belong to the same surface: noise, and its slope.
constexpr double kSurfaceDepthM = 0.08;

/// A point of the cloud in the picture.
struct Splat {
  size_t point;
  Eigen::Vector2f pixel;
  float range;
  int radius;

  /// Calls visit(x, y) for the pixels of its square inside the picture.
  template <typename Visit>
  void for_pixels(const ColorImage& picture, const Visit& visit) const {
    const Eigen::Vector2i center = (pixel.array() + 0.5f).floor().cast<int>();
    for (int y = std::max(0, center.y() - radius); y <= std::min(picture.height - 1, center.y() + radius); ++y) {
      for (int x = std::max(0, center.x() - radius); x <= std::min(picture.width - 1, center.x() + radius); ++x) {
        visit(x, y);
      }
    }
  }

  /// A bell whose standard deviation is half the radius: the nearest points give most of a pixel's colour.
  float weight_at(int x, int y) const {
    const float sigma = 0.5f * static_cast<float>(std::max(radius, 1));
    const float dx = static_cast<float>(x) - pixel.x(), dy = static_cast<float>(y) - pixel.y();
    return std::exp(-0.5f * (dx * dx + dy * dy) / (sigma * sigma));
  }
};

/// Whether the surface has a range there, and the point is well behind all of it around.
bool is_behind(const DepthBuffer& surface, const Eigen::Vector2d& pixel, double range) {
  const auto farthest = static_cast<double>(surface.farthest_range_near(pixel));
  return farthest > 0.0 && range > farthest + kSurfaceDepthM;
}

/// Where a point is drawn; nothing where it is not.
std::optional<Eigen::Vector2d> drawn_pixel(const Eigen::Vector3d& x_in_camera, const DepthBuffer& surface) {
  const auto pixel = surface.camera.project(x_in_camera);
  if (!pixel || !surface.camera.in_image(*pixel, -kMaxRadiusPx)) return std::nullopt;
  if (is_behind(surface, *pixel, x_in_camera.norm())) return std::nullopt;
  return *pixel;
}

std::vector<Splat> project_cloud(const PointCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map,
                                 double point_size_m) {
  const Camera& camera = surface.camera;
  std::vector<Splat> splats;
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d x_in_camera = camera_from_map * cloud.point(i);
    const auto pixel = drawn_pixel(x_in_camera, surface);
    if (!pixel) continue;
    const double range = x_in_camera.norm();
    const double half_size_px = 0.5 * point_size_m * camera.pixels_per_radian() / range;
    const int radius = static_cast<int>(std::lround(std::min(half_size_px, double{kMaxRadiusPx})));
    splats.push_back({i, pixel->cast<float>(), static_cast<float>(range), radius});
  }
  return splats;
}

/// Sum of the weighted colours of some points at a pixel.
struct ColorSum {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float weight = 0.0f;

  void add(const Rgb& rgb, float w) {
    color += w * Eigen::Vector3f(rgb[0], rgb[1], rgb[2]);
    weight += w;
  }
  Rgb mean() const {
    Rgb rgb;
    for (size_t c = 0; c < 3; ++c) rgb[c] = static_cast<uint8_t>(color[static_cast<int>(c)] / weight + 0.5f);
    return rgb;
  }
};

}  // namespace

CloudRendering render_colored_cloud(const PointCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map,
                                    double point_size_m) {
  const Camera& camera = surface.camera;
  if (cloud.colors.size() != cloud.size()) throw Error("a cloud without colours cannot be rendered");
  CloudRendering rendering{ColorImage(camera.width(), camera.height(), kBackground),
                           Image<uint8_t>(camera.width(), camera.height(), 0)};
  const std::vector<Splat> splats = project_cloud(cloud, surface, camera_from_map, point_size_m);
  RangeImage nearest(camera.width(), camera.height(), std::numeric_limits<float>::infinity());
  for (const Splat& splat : splats) {
    splat.for_pixels(rendering.picture,
                     [&](int x, int y) { nearest.at(x, y) = std::min(nearest.at(x, y), splat.range); });
  }
  Image<ColorSum> colored(camera.width(), camera.height()), plain(camera.width(), camera.height());
  for (const Splat& splat : splats) {
    Image<ColorSum>& sums = cloud.num_views.empty() || cloud.num_views[splat.point] > 0 ? colored : plain;
    splat.for_pixels(rendering.picture, [&](int x, int y) {
      if (splat.range <= nearest.at(x, y) + static_cast<float>(kSurfaceDepthM))
        sums.at(x, y).add(cloud.colors[splat.point], splat.weight_at(x, y));
    });
  }
  for (size_t i = 0; i < rendering.picture.pixels.size(); ++i) {
    const bool is_colored = colored.pixels[i].weight > plain.pixels[i].weight;
    const ColorSum& sum = is_colored ? colored.pixels[i] : plain.pixels[i];
    if (sum.weight == 0.0f) continue;
    rendering.picture.pixels[i] = sum.mean();
    rendering.colored.pixels[i] = is_colored ? 1 : 0;
  }
  return rendering;
}

bool is_drawn(const Eigen::Vector3d& x_in_camera, const DepthBuffer& surface) {
  return drawn_pixel(x_in_camera, surface).has_value();
}

ColorImage render_cloud(const PointCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map,
                        double point_size_m) {
  return render_colored_cloud(cloud, surface, camera_from_map, point_size_m).picture;
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
