#include "cpplus/colorize/surface_normals.h"

#include <Eigen/Eigenvalues>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

constexpr size_t kMinPoints = 6;
constexpr double kMaxVarianceRatio = 0.2;

}  // namespace

SurfaceNormals estimate_surface_normals(const VoxelMap& map, double voxel_size_m) {
  SurfaceNormals normals;
  // The small allowance makes 0.25 m mean the layer of 0.25 m, whatever the rounding.
  while (normals.layer < map.leaf_layer() && map.voxel_size(normals.layer + 1) >= voxel_size_m * (1.0 - 1e-9)) {
    ++normals.layer;
  }
  normals.of_node.assign(map.num_nodes(normals.layer), Eigen::Vector3f::Zero());
  parallel_for_chunks(normals.of_node.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t node = begin; node < end; ++node) {
      const VoxelStatistics statistics = map.statistics(normals.layer, static_cast<uint32_t>(node));
      if (statistics.count < kMinPoints) continue;
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
      solver.computeDirect(statistics.covariance);
      if (solver.eigenvalues()(0) >= kMaxVarianceRatio * solver.eigenvalues()(1)) continue;
      normals.of_node[node] = solver.eigenvectors().col(0).cast<float>();
    }
  });
  return normals;
}

}  // namespace cpplus
