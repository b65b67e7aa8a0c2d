#include "cpplus/visibility/points_on_planes.h"

#include <cmath>

#include "cpplus/visibility/projected_points.h"

namespace cpplus {

std::vector<PointInView> points_on_seen_planes(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                               const PlaneBuffer& planes, double max_distance_m, double margin_m) {
  std::vector<PointInView> seen;
  const auto visit = [&](std::span<const ProjectedPoint> points, std::span<const uint32_t> indices) {
    for (size_t i = 0; i < points.size(); ++i) {
      const int32_t id = planes.plane_at(points[i].pixel.cast<double>());
      if (id == PlaneBuffer::kNone) continue;
      const MapPlane& plane = (*planes.planes)[static_cast<size_t>(id)];
      if (std::abs(plane.signed_distance(map.point(indices[i]))) <= margin_m) {
        seen.push_back({indices[i], points[i].pixel});
      }
    }
  };
  project_points(map, leaf_spacing, planes, max_distance_m, visit);
  return seen;
}

}  // namespace cpplus
