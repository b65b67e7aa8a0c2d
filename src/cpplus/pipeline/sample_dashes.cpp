#include "cpplus/pipeline/sample_dashes.h"

namespace cpplus {

std::vector<OverlaySegment> sample_dashes(const std::vector<EdgeSample>& samples, const Camera& camera,
                                          const Rigid3& camera_from_map, double spacing_px) {
  std::vector<OverlaySegment> segments;
  const Eigen::Vector3d center = camera_center(camera_from_map);
  for (const EdgeSample& sample : samples) {
    const double half_m = 0.5 * spacing_px * (sample.x_in_map - center).norm() / camera.pixels_per_radian();
    segments.push_back(
        {sample.x_in_map - half_m * sample.direction_in_map, sample.x_in_map + half_m * sample.direction_in_map});
  }
  return segments;
}

}  // namespace cpplus
