#include "cpplus/cloud/depth_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cpplus {

Eigen::Vector2i DepthBuffer::cell_of(const Eigen::Vector2d& pixel) const {
  // Clamped, so that int does not overflow, to -1 at least: cutting off the fraction of what is not negative is to
  // floor.
  const auto floor_within = [](double cell, int size) {
    return static_cast<int>(std::clamp(cell + 1.0, 0.0, size + 1.0)) - 1;
  };
  return {floor_within((pixel.x() + 0.5) / cell_px + margin_cells, range.width),
          floor_within((pixel.y() + 0.5) / cell_px + margin_cells, range.height)};
}

Eigen::Vector2d DepthBuffer::center_of(const Eigen::Vector2i& cell) const {
  return ((cell.cast<double>().array() - margin_cells + 0.5) * cell_px - 0.5).matrix();
}

int DepthBuffer::column(int x) const {
  if (x >= 0 && x < range.width) return x;
  return wraps ? (x % range.width + range.width) % range.width : -1;
}

float DepthBuffer::range_at(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2i cell = cell_of(pixel);
  return range.contains(cell.x(), cell.y()) ? range.at(cell.x(), cell.y()) : 0.0f;
}

float DepthBuffer::farthest_range_near(const Eigen::Vector2d& pixel, int reach) const {
  const Eigen::Vector2i cell = cell_of(pixel);
  if (!range.contains(cell.x(), cell.y())) return 0.0f;
  float farthest = 0.0f;
  for (int y = std::max(cell.y() - reach, 0); y <= std::min(cell.y() + reach, range.height - 1); ++y) {
    for (int x = cell.x() - reach; x <= cell.x() + reach; ++x) {
      const int column_x = column(x);
      if (column_x < 0) continue;
      const float r = range.at(column_x, y);
      if (r == 0.0f) return std::numeric_limits<float>::infinity();
      farthest = std::max(farthest, r);
    }
  }
  return farthest;
}

bool DepthBuffer::is_visible(const Eigen::Vector3d& x_in_camera, double tolerance_m) const {
  const auto pixel = camera.project(x_in_camera);
  return pixel && x_in_camera.norm() <= static_cast<double>(farthest_range_near(*pixel)) + tolerance_m;
}

}  // namespace cpplus
