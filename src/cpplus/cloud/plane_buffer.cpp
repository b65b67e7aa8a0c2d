#include "cpplus/cloud/plane_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cpplus {

int32_t PlaneBuffer::plane_at(const Eigen::Vector2d& pixel) const {
  const int x = static_cast<int>(std::floor((pixel.x() + 0.5) / cell_px));
  const int y = static_cast<int>(std::floor((pixel.y() + 0.5) / cell_px));
  return plane.contains(x, y) ? plane.at(x, y) : kNone;
}

bool PlaneBuffer::is_visible(const Eigen::Vector3d& x_in_map, const Eigen::Vector2d& pixel, double margin_m) const {
  const Eigen::Vector3d center = camera_center(camera_from_map);
  const int cx = static_cast<int>(std::floor((pixel.x() + 0.5) / cell_px));
  const int cy = static_cast<int>(std::floor((pixel.y() + 0.5) / cell_px));
  for (int y = std::max(0, cy - 1); y <= std::min(plane.height - 1, cy + 1); ++y) {
    for (int x = std::max(0, cx - 1); x <= std::min(plane.width - 1, cx + 1); ++x) {
      const int32_t id = plane.at(x, y);
      if (id == kNone) return true;
      const MapPlane& occluder = (*planes)[static_cast<size_t>(id)];
      const double camera_side = occluder.signed_distance(center);
      const double point_side = occluder.signed_distance(x_in_map);
      if (camera_side * point_side >= 0 || std::abs(point_side) <= margin_m) return true;
    }
  }
  return false;
}

double PlaneBuffer::range_along(const MapPlane& plane_instance, const Eigen::Vector3d& bearing) const {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const double slope = plane_instance.normal.dot(camera_from_map.rotation.conjugate() * bearing);
  if (std::abs(slope) < 1e-6) return kNan;
  const double range = -plane_instance.signed_distance(camera_center(camera_from_map)) / slope;
  return range > 0 ? range : kNan;
}

double PlaneBuffer::range_of(const MapPlane& plane_instance, const Eigen::Vector2d& pixel) const {
  const auto bearing = camera.unproject(pixel);
  return bearing ? range_along(plane_instance, *bearing) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace cpplus
