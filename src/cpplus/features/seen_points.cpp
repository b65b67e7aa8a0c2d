#include "cpplus/features/seen_points.h"

#include <optional>

namespace cpplus {
namespace {

constexpr double kStepPx = 5.0;  // of the differences that give the bearings' derivatives

// Bearings near a pixel, linear in the pixel.
struct LinearBearings {
  Eigen::Vector2d pixel;
  Eigen::Vector3d bearing;
  Eigen::Matrix<double, 3, 2> by_pixel;

  Eigen::Vector3d at(const Eigen::Vector2d& where) const { return (bearing + by_pixel * (where - pixel)).normalized(); }
};

std::optional<LinearBearings> bearings_near(const Camera& camera, const Eigen::Vector2d& pixel) {
  LinearBearings near;
  near.pixel = pixel;
  const auto middle = camera.unproject(pixel);
  if (!middle) return std::nullopt;
  near.bearing = *middle;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kStepPx * Eigen::Vector2d::Unit(axis);
    const auto before = camera.unproject(pixel - step);
    const auto after = camera.unproject(pixel + step);
    if (!before || !after) return std::nullopt;
    near.by_pixel.col(axis) = (*after - *before) / (2.0 * kStepPx);
  }
  return near;
}

}  // namespace

SeenSquare points_around(const Camera& camera, const RangeRaster& raster, const Eigen::Vector2d& pixel,
                         double radius_px) {
  SeenSquare square;
  const auto bearings = bearings_near(camera, pixel);
  if (!bearings) return square;
  const Eigen::Vector2f reach = Eigen::Vector2f::Constant(static_cast<float>(radius_px));
  const Eigen::Vector2i first = raster.cell_of(pixel.cast<float>() - reach);
  const Eigen::Vector2i last = raster.cell_of(pixel.cast<float>() + reach);
  int num_cells = 0, num_filled = 0;
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      ++num_cells;
      const double nearest = static_cast<double>(raster.range_at({x, y}));
      if (!(nearest > 0.0)) continue;
      ++num_filled;
      const std::span<const PointsByCell::Point> points = raster.points_in({x, y});
      for (const PointsByCell::Point& point : points) {
        square.points.push_back({bearings->at(point.pixel.cast<double>()), static_cast<double>(point.range), nearest,
                                 static_cast<uint32_t>(square.num_cells)});
      }
      square.num_cells += points.empty() ? 0 : 1;
    }
  }
  square.share_filled = static_cast<double>(num_filled) / num_cells;
  return square;
}

}  // namespace cpplus
