#include "cpplus/features/settle_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/features/leaf_planes.h"
#include "cpplus/features/moments.h"

namespace cpplus {
namespace {

// A plane's own spread, kept near the noise of the map: relief must not buy it points.
double reach_of(const MapPlane& plane, double noise_m) { return std::clamp(plane.sigma_m, noise_m, 1.5 * noise_m); }

// The plane of each point after the change.
std::vector<int32_t> nearest_planes(const VoxelMap& map, double max_sigmas, const PlaneSegmentation& planes) {
  const LeafPlanes planes_of_leaf(map, planes.plane_of_point);
  std::vector<int32_t> settled = planes.plane_of_point;
  const int leaf_layer = map.leaf_layer();
  parallel_for_chunks(map.num_nodes(leaf_layer), 4096, [&](size_t begin, size_t end) {
    std::vector<uint32_t> neighbors;
    std::vector<int32_t> candidates;
    for (size_t k = begin; k < end; ++k) {
      const uint32_t leaf = static_cast<uint32_t>(k);
      if (planes_of_leaf[leaf].empty()) continue;
      candidates.assign(planes_of_leaf[leaf].begin(), planes_of_leaf[leaf].end());
      map.neighbors(leaf_layer, leaf, false, &neighbors);
      for (const uint32_t neighbor : neighbors) {
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

// New numbers of the planes; kNone = given up.
std::vector<int32_t> keep_large(const std::vector<Moments>& moments, int min_points) {
  std::vector<int32_t> new_id(moments.size(), PlaneSegmentation::kNone);
  int32_t kept = 0;
  for (size_t p = 0; p < moments.size(); ++p) {
    if (moments[p].count() >= static_cast<size_t>(min_points)) new_id[p] = kept++;
  }
  return new_id;
}

}  // namespace

void settle_points(const VoxelMap& map, const SettlePointsOptions& options, PlaneSegmentation* planes) {
  const std::vector<int32_t> settled = nearest_planes(map, options.max_distance_sigmas, *planes);
  std::vector<Moments> moments;
  for (const MapPlane& plane : planes->planes) moments.emplace_back(plane.centroid);
  for (size_t i = 0; i < settled.size(); ++i) {
    if (settled[i] >= 0) moments[static_cast<size_t>(settled[i])].add(map.point(i));
  }
  const std::vector<int32_t> new_id = keep_large(moments, options.min_plane_points);
  planes->planes.clear();
  for (size_t p = 0; p < moments.size(); ++p) {
    if (new_id[p] < 0) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments[p].covariance());
    planes->planes.push_back({eigen.eigenvectors().col(0), moments[p].mean(),
                              std::sqrt(std::max(0.0, eigen.eigenvalues()(0))),
                              static_cast<uint32_t>(moments[p].count())});
  }
  planes->leaves.assign(planes->planes.size(), {});
  for (uint32_t leaf = 0; leaf < map.num_nodes(map.leaf_layer()); ++leaf) {
    for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
      const int32_t id = settled[i] < 0 ? PlaneSegmentation::kNone : new_id[static_cast<size_t>(settled[i])];
      planes->plane_of_point[i] = id;
      if (id < 0) continue;
      std::vector<uint32_t>& leaves = planes->leaves[static_cast<size_t>(id)];
      if (leaves.empty() || leaves.back() != leaf) leaves.push_back(leaf);
    }
  }
}

}  // namespace cpplus
