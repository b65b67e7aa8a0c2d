#include "cpplus/features/settle_points.h"

#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/features/leaf_planes.h"
#include "cpplus/features/refit_planes.h"

namespace cpplus {
namespace {

// A plane's own spread, kept near the noise of the map: relief must not buy it points.
double reach_of(const MapPlane& plane, double noise_m) { return std::clamp(plane.sigma_m, noise_m, 1.5 * noise_m); }

// The plane of each point after the change.
std::vector<int32_t> nearest_planes(const VoxelMap& map, const LeafNeighbors& neighbors, double max_sigmas,
                                    const PlaneSegmentation& planes) {
  const LeafPlanes planes_of_leaf(map, planes.plane_of_point);
  std::vector<int32_t> settled = planes.plane_of_point;
  const int leaf_layer = map.leaf_layer();
  parallel_for_chunks(map.num_nodes(leaf_layer), 4096, [&](size_t begin, size_t end) {
    std::vector<int32_t> candidates;
    for (size_t k = begin; k < end; ++k) {
      const uint32_t leaf = static_cast<uint32_t>(k);
      if (planes_of_leaf[leaf].empty()) continue;
      candidates.assign(planes_of_leaf[leaf].begin(), planes_of_leaf[leaf].end());
      for (const uint32_t neighbor : neighbors[leaf]) {
        for (const int32_t id : planes_of_leaf[neighbor]) {
          if (std::find(candidates.begin(), candidates.end(), id) == candidates.end()) candidates.push_back(id);
        }
      }
      if (candidates.size() < 2) continue;
      std::sort(candidates.begin(), candidates.end());
      for (uint32_t i = map.points_begin(leaf_layer, leaf); i < map.points_end(leaf_layer, leaf); ++i) {
        if (settled[i] == PlaneSegmentation::kNone) continue;
        const Eigen::Vector3d x = map.point(i);
        double nearest = max_sigmas;
        for (const int32_t id : candidates) {
          const MapPlane& plane = planes.planes[static_cast<size_t>(id)];
          const double distance = std::abs(plane.signed_distance(x)) / reach_of(plane, planes.noise_m);
          if (distance >= nearest) continue;
          nearest = distance;
          settled[i] = id;
        }
      }
    }
  });
  return settled;
}

}  // namespace

void settle_points(const VoxelMap& map, const LeafNeighbors& neighbors, const SettlePointsOptions& options,
                   PlaneSegmentation* planes) {
  refit_planes(map, nearest_planes(map, neighbors, options.max_distance_sigmas, *planes), options.min_plane_points,
               planes);
}

}  // namespace cpplus
