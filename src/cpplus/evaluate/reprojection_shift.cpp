#include "cpplus/evaluate/reprojection_shift.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cpplus/evaluate/statistics.h"

namespace cpplus {
namespace {

double pixel_distance(const Camera& camera, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  Eigen::Vector2d difference = (a - b).cwiseAbs();
  if (camera.model() == CameraModel::kEquirectangular) {
    difference.x() = std::min(difference.x(), std::abs(camera.width() - difference.x()));
  }
  return difference.norm();
}

}  // namespace

std::vector<Eigen::Vector3d> visible_points_from_ranges(const RangeGrid& grid, const Camera& camera,
                                                        const Rigid3& camera_from_map) {
  const Rigid3 map_from_camera = inverse(camera_from_map);
  std::vector<Eigen::Vector3d> points_in_map;
  for (int j = 0; j < grid.ranges.height; ++j) {
    for (int i = 0; i < grid.ranges.width; ++i) {
      const double range = grid.ranges.at(i, j);
      if (!std::isfinite(range) || range <= 0.0) continue;
      const Eigen::Vector2d pixel = grid.first_pixel + grid.step_px * Eigen::Vector2d(i, j);
      if (const auto bearing = camera.unproject(pixel)) points_in_map.push_back(map_from_camera * (range * *bearing));
    }
  }
  return points_in_map;
}

ReprojectionShift reprojection_shift(const std::vector<Eigen::Vector3d>& points_in_map, const Camera& camera,
                                     const Rigid3& estimate_camera_from_map, const Rigid3& reference_camera_from_map) {
  const double cap_px = std::hypot(camera.width(), camera.height());
  size_t num_lost = 0;
  std::vector<double> shifts_px;
  shifts_px.reserve(points_in_map.size());
  for (const Eigen::Vector3d& point : points_in_map) {
    const std::optional<Eigen::Vector2d> reference = camera.project(reference_camera_from_map * point);
    if (!reference) continue;
    const std::optional<Eigen::Vector2d> estimate = camera.project(estimate_camera_from_map * point);
    num_lost += estimate ? 0 : 1;
    shifts_px.push_back(estimate ? std::min(cap_px, pixel_distance(camera, *estimate, *reference)) : cap_px);
  }
  const SampleStatistics statistics = sample_statistics(std::move(shifts_px));
  return {statistics.count, num_lost, statistics.mean, statistics.median, statistics.max};
}

}  // namespace cpplus
