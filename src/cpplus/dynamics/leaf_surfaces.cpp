#include "cpplus/dynamics/leaf_surfaces.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/scan_hits.h"

namespace cpplus {
namespace {

using Eigen::Vector3f;

constexpr size_t kNodesPerTask = 2048;

/// The plane of points with these statistics, where they are one: more than a line, and thin.
std::optional<SurfacePatch> patch_of(size_t count, const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance) {
  constexpr size_t kMinPoints = 8;
  constexpr double kMinWidth = 0.04;      // standard deviation across the points of a line, metres
  constexpr double kMaxThickness = 0.15;  // variances across to along; 2 cm noise on a 25 cm voxel has 0.08
  if (count < kMinPoints) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d& variances = solver.eigenvalues();
  if (variances[1] < kMinWidth * kMinWidth || variances[0] > kMaxThickness * variances[1]) return std::nullopt;
  return SurfacePatch{mean.cast<float>(), solver.eigenvectors().col(0).cast<float>()};
}

/// Number of scans and mean of the points of one leaf.
void measure_leaf(const VoxelMap& map, const ScanOfPoint& scan_of_point, uint32_t leaf, LeafSurfaces* surfaces) {
  for_each_scan_of_leaf(map, scan_of_point, leaf, [&](uint32_t, uint32_t) { ++surfaces->num_scans[leaf]; });
  const uint32_t begin = map.points_begin(map.leaf_layer(), leaf);
  const uint32_t end = map.points_end(map.leaf_layer(), leaf);
  Vector3f sum = Vector3f::Zero();
  for (uint32_t i = begin; i < end; ++i) sum += map.positions()[i] - map.positions()[begin];
  surfaces->means[leaf] = map.positions()[begin] + sum / static_cast<float>(end - begin);
}

void set_normals(const VoxelMap& map, int layer, LeafSurfaces* surfaces) {
  constexpr float kMaxDistance = 0.05f;  // of a leaf's mean from the plane, metres
  parallel_for_chunks(map.num_nodes(layer), kNodesPerTask, [&](size_t begin, size_t end) {
    for (auto node = static_cast<uint32_t>(begin); node < end; ++node) {
      const VoxelStatistics points = map.statistics(layer, node);
      const auto patch = patch_of(points.count, points.mean - map.origin(), points.covariance);
      if (!patch) continue;
      const NodeRange leaves = leaves_of(map, layer, node);
      for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
        const float distance = patch->normal.dot(surfaces->means[leaf] - patch->mean);
        if (std::abs(distance) < kMaxDistance) surfaces->normals[leaf] = patch->normal;
      }
    }
  });
}

}  // namespace

std::optional<SurfacePatch> fit_patch(const std::vector<Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (const Vector3f& point : points) {
    const Eigen::Vector3d x = (point - points.front()).cast<double>();
    sum += x;
    products += x * x.transpose();
  }
  if (points.empty()) return std::nullopt;
  const auto count = static_cast<double>(points.size());
  const Eigen::Vector3d mean = sum / count;
  return patch_of(points.size(), points.front().cast<double>() + mean, products / count - mean * mean.transpose());
}

LeafSurfaces measure_leaf_surfaces(const VoxelMap& map, const ScanSet& scans) {
  const int leaf_layer = map.leaf_layer();
  const uint32_t num_leaves = map.num_nodes(leaf_layer);
  const ScanOfPoint scan_of_point(scans);
  LeafSurfaces surfaces;
  surfaces.num_scans.assign(num_leaves, 0);
  surfaces.means.resize(num_leaves);
  surfaces.normals.assign(num_leaves, Vector3f::Zero());
  parallel_for_chunks(num_leaves, kNodesPerTask, [&](size_t begin, size_t end) {
    for (auto leaf = static_cast<uint32_t>(begin); leaf < end; ++leaf)
      measure_leaf(map, scan_of_point, leaf, &surfaces);
  });
  // The finer plane comes last and so holds.
  for (const int layers_up : {3, 2}) set_normals(map, std::max(0, leaf_layer - layers_up), &surfaces);
  return surfaces;
}

}  // namespace cpplus
