#include "cpplus/pipeline/color_view_depth.h"

#include "cpplus/visibility/depth_buffer.h"

namespace cpplus {

DepthBuffer color_view_depth(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                             double max_distance_m) {
  constexpr double kCellPx = 2.0;
  DepthBufferOptions options;
  options.max_distance_m = max_distance_m;
  options.cell_leaves = kCellPx * max_distance_m / (map.options().leaf_size_m * camera.pixels_per_radian());
  return render_depth_buffer(map, camera, camera_from_map, options);
}

}  // namespace cpplus
