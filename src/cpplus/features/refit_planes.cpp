#include "cpplus/features/refit_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "cpplus/cloud/moments.h"

namespace cpplus {
namespace {

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

void refit_planes(const VoxelMap& map, const std::vector<int32_t>& plane_of_point, int min_plane_points,
                  PlaneSegmentation* planes) {
  std::vector<Moments> moments;
  for (const MapPlane& plane : planes->planes) moments.emplace_back(plane.centroid);
  for (size_t i = 0; i < plane_of_point.size(); ++i) {
    if (plane_of_point[i] >= 0) moments[static_cast<size_t>(plane_of_point[i])].add(map.point(i));
  }
  const std::vector<int32_t> new_id = keep_large(moments, min_plane_points);
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
      const int32_t id =
          plane_of_point[i] < 0 ? PlaneSegmentation::kNone : new_id[static_cast<size_t>(plane_of_point[i])];
      planes->plane_of_point[i] = id;
      if (id < 0) continue;
      std::vector<uint32_t>& leaves = planes->leaves[static_cast<size_t>(id)];
      if (leaves.empty() || leaves.back() != leaf) leaves.push_back(leaf);
    }
  }
}

}  // namespace cpplus
