#include "cpplus/pipeline/visible_map_points.h"

#include <algorithm>
#include <cmath>

#include "cpplus/evaluate/reprojection_shift.h"
#include "cpplus/visibility/depth_buffer.h"

namespace cpplus {
namespace {

constexpr double kMaxDistanceM = 50.0;
constexpr double kSpacingPx = 8.0;

}  // namespace

std::vector<Eigen::Vector3d> visible_map_points(const VoxelMap& map, const Camera& camera,
                                                const Rigid3& camera_from_map) {
  DepthBufferOptions options;
  options.max_distance_m = kMaxDistanceM;
  const DepthBuffer buffer = render_depth_buffer(map, camera, camera_from_map, options);
  const int stride = std::max(1, static_cast<int>(std::lround(kSpacingPx / buffer.cell_px)));
  RangeGrid grid;
  grid.ranges = RangeImage((buffer.range.width + stride - 1) / stride, (buffer.range.height + stride - 1) / stride);
  grid.step_px = stride * buffer.cell_px;
  grid.first_pixel = buffer.center_of({0, 0});
  for (int y = 0; y < grid.ranges.height; ++y) {
    for (int x = 0; x < grid.ranges.width; ++x) grid.ranges.at(x, y) = buffer.range.at(x * stride, y * stride);
  }
  return visible_points_from_ranges(grid, camera, camera_from_map);
}

}  // namespace cpplus
