#include "cpplus/adjust/pose_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <numeric>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Derivatives of the distances n'(x - q) of a cluster's points, summed over the points with the cluster's weight.
/// Parameters of the plane: a turn of n towards either tangent, and a shift along n.
struct ClusterTerms {
  Matrix6d pose_pose = Matrix6d::Zero();
  Matrix63 pose_plane = Matrix63::Zero();
  Matrix3d plane_plane = Matrix3d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

ClusterTerms cluster_terms(const ScanCluster& cluster, double weight, const PatchPlane& plane, const Matrix32& tangents,
                           const Vector3d& sensor) {
  const Vector3d& n = plane.normal;
  Vector6d pose;
  pose << (cluster.mean - sensor).cross(n), n;
  Vector3d shape;
  shape << tangents.transpose() * (cluster.mean - plane.mean), -1.0;
  const double distance = n.dot(cluster.mean - plane.mean);
  const Matrix3d turned = -cross_matrix(n) * cluster.covariance;  // sum of (s x n) s'

  ClusterTerms terms;
  terms.pose_pose = pose * pose.transpose();
  terms.pose_pose.topLeftCorner<3, 3>() += turned * cross_matrix(n);
  terms.pose_plane = pose * shape.transpose();
  terms.pose_plane.topLeftCorner<3, 2>() += turned * tangents;
  terms.plane_plane = shape * shape.transpose();
  terms.plane_plane.topLeftCorner<2, 2>() += tangents.transpose() * cluster.covariance * tangents;
  terms.gradient = pose * distance;
  terms.gradient.head<3>() += turned * n;
  terms.pose_pose *= weight;
  terms.pose_plane *= weight;
  terms.plane_plane *= weight;
  terms.gradient *= weight;
  return terms;
}

Matrix32 tangents_of(const Vector3d& normal) {
  Matrix32 tangents;
  tangents.col(0) = normal.unitOrthogonal();
  tangents.col(1) = normal.cross(tangents.col(0));
  return tangents;
}

/// Per cluster Z = B L^-T with B its pose-plane block and L L' the patch's plane-plane block, so that eliminating the
/// plane takes Z_i Z_j' off block (i, j).
std::vector<Matrix63> eliminate_plane(const WeightedPatch& patch, const std::vector<Vector3d>& sensors) {
  const Matrix32 tangents = tangents_of(patch.plane.normal);
  std::vector<Matrix63> blocks(patch.clusters.size());
  Matrix3d plane_plane = Matrix3d::Zero();
  for (size_t k = 0; k < blocks.size(); ++k) {
    const ScanCluster& cluster = patch.clusters[k];
    const ClusterTerms terms = cluster_terms(cluster, patch.weights[k], patch.plane, tangents, sensors[cluster.scan]);
    blocks[k] = terms.pose_plane;
    plane_plane += terms.plane_plane;
  }
  const Matrix3d lower = plane_plane.llt().matrixL();
  for (Matrix63& block : blocks) {
    block = lower.triangularView<Eigen::Lower>().solve(block.transpose()).transpose().eval();
  }
  return blocks;
}

struct ClusterName {
  size_t patch;
  size_t cluster;
};

}  // namespace

PoseEquations::PoseEquations(size_t num_scans) : rows(num_scans), gradients(num_scans, Vector6d::Zero()) {
  for (size_t i = 0; i < num_scans; ++i) rows[i].assign(num_scans - i, Matrix6d::Zero());
}

void PoseEquations::add_prior(size_t scan, const Vector6d& offset, const Vector6d& information) {
  rows[scan][0].diagonal() += information;
  gradients[scan] += information.cwiseProduct(offset);
}

void PoseEquations::add_smoothness(size_t scan, const Vector6d& offset, const Vector6d& information) {
  const Vector6d pull = information.cwiseProduct(offset);
  rows[scan][0].diagonal() += information;
  rows[scan + 1][0].diagonal() += information;
  rows[scan][1].diagonal() -= information;
  gradients[scan] -= pull;
  gradients[scan + 1] += pull;
}

Eigen::MatrixXd PoseEquations::dense() const {
  const auto size = static_cast<Eigen::Index>(6 * num_scans());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t k = 0; k < rows[i].size(); ++k) {
      const auto row = static_cast<Eigen::Index>(6 * i);
      const auto column = static_cast<Eigen::Index>(6 * (i + k));
      matrix.block<6, 6>(row, column) = rows[i][k];
      matrix.block<6, 6>(column, row) = rows[i][k].transpose();
    }
  }
  return matrix;
}

Eigen::VectorXd PoseEquations::solve() const {
  const auto size = static_cast<Eigen::Index>(6 * num_scans());
  Eigen::VectorXd right(size);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t i = 0; i < rows.size(); ++i) {
    right.segment<6>(static_cast<Eigen::Index>(6 * i)) = -gradients[i];
    for (size_t k = 0; k < rows[i].size(); ++k) {
      if (rows[i][k].isZero(0.0)) continue;
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) {
          const int row = static_cast<int>(6 * i) + r;
          const int column = static_cast<int>(6 * (i + k)) + c;
          if (row <= column) entries.emplace_back(row, column, rows[i][k](r, c));
        }
      }
    }
  }
  constexpr double kDenseShare = 0.3;  // a sparse factorisation is slower from about here on
  if (static_cast<double>(entries.size()) > 0.5 * kDenseShare * static_cast<double>(size * size))
    return dense().llt().solve(right);
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Upper>(matrix).solve(right);
}

void add_patches(const std::vector<WeightedPatch>& patches, const std::vector<Vector3d>& sensors,
                 PoseEquations* equations) {
  constexpr size_t kGrain = 64;
  std::vector<std::vector<Matrix63>> blocks(patches.size());
  parallel_for_chunks(patches.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t p = begin; p < end; ++p) blocks[p] = eliminate_plane(patches[p], sensors);
  });
  std::vector<std::vector<ClusterName>> clusters_of_scan(sensors.size());
  for (size_t p = 0; p < patches.size(); ++p) {
    for (size_t k = 0; k < patches[p].clusters.size(); ++k)
      clusters_of_scan[patches[p].clusters[k].scan].push_back({p, k});
  }
  // A row of blocks belongs to one task, which adds the patches in their order: the same sum for any number of threads.
  parallel_for_each(sensors.size(), [&](size_t scan) {
    std::vector<Matrix6d>& row = equations->rows[scan];
    for (const ClusterName& name : clusters_of_scan[scan]) {
      const WeightedPatch& patch = patches[name.patch];
      const ClusterTerms terms = cluster_terms(patch.clusters[name.cluster], patch.weights[name.cluster], patch.plane,
                                               tangents_of(patch.plane.normal), sensors[scan]);
      row[0] += terms.pose_pose;
      equations->gradients[scan] += terms.gradient;
      const Matrix63& own = blocks[name.patch][name.cluster];
      for (size_t k = name.cluster; k < patch.clusters.size(); ++k)
        row[patch.clusters[k].scan - scan].noalias() -= own * blocks[name.patch][k].transpose();
    }
  });
}

double patch_cost(const std::vector<WeightedPatch>& patches) {
  double cost = 0.0;
  for (const WeightedPatch& patch : patches)
    cost += 0.5 * patch.plane.smallest * std::accumulate(patch.weights.begin(), patch.weights.end(), 0.0);
  return cost;
}

}  // namespace cpplus
