#include "cpplus/pipeline/map_discs.h"

#include "cpplus/colorize/surface_normals.h"
#include "cpplus/core/parallel.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/visibility/point_spacing.h"

namespace cpplus {

MapDiscs make_map_discs(const VoxelMap& map) {
  constexpr double kNormalVoxelM = 0.25;
  MapDiscs discs;
  discs.leaf_spacing_m = leaf_point_spacing(map);
  discs.normals.assign(map.num_points(), Eigen::Vector3f::Zero());
  const PlaneSegmentation planes = segment_planes(map, {});
  const SurfaceNormals normals = estimate_surface_normals(map, kNormalVoxelM);
  parallel_for_chunks(normals.of_node.size(), 256, [&](size_t begin, size_t end) {
    for (size_t node = begin; node < end; ++node) {
      const uint32_t points_end = map.points_end(normals.layer, static_cast<uint32_t>(node));
      for (uint32_t i = map.points_begin(normals.layer, static_cast<uint32_t>(node)); i < points_end; ++i) {
        const int32_t plane = planes.plane_of_point[i];
        discs.normals[i] = plane >= 0 ? Eigen::Vector3f(planes.planes[static_cast<size_t>(plane)].normal.cast<float>())
                                      : normals.of_node[node];
      }
    }
  });
  return discs;
}

}  // namespace cpplus
