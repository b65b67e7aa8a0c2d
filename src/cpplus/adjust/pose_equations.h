#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/adjust/scan_patches.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A patch at the present poses: its clusters moved there, their information weights (1/m^2), and the plane that fits
/// them best.
struct WeightedPatch {
  std::vector<ScanCluster> clusters;
  std::vector<double> weights;
  PatchPlane plane;
};

/// Symmetric equations H d = -g of all scans' corrections, in blocks of six: block (i, i + k) is rows[i][k].
///
/// The correction d_i of a scan turns its points about the sensor, c_i + Exp(d[0..2]) (x - c_i) + d[3..5], map frame.
struct PoseEquations {
  std::vector<std::vector<Matrix6d>> rows;
  std::vector<Vector6d> gradients;

  explicit PoseEquations(size_t num_scans);
  size_t num_scans() const { return gradients.size(); }

  /// Adds the cost of d_i + offset (and of the difference of the corrections of i and i + 1 plus offset), each
  /// component weighted by information / 2.
  void add_prior(size_t scan, const Vector6d& offset, const Vector6d& information);
  void add_smoothness(size_t scan, const Vector6d& offset, const Vector6d& information);

  /// All corrections one below the other. Sparse factorisation, dense where most blocks are filled.
  Eigen::VectorXd solve() const;
  Eigen::MatrixXd dense() const;
};

/// Adds half the cost sum_p sum_i w_i (n' S_i n + (n' (m_i - q))^2), least over the planes (n, q): gradient exact,
/// Hessian by Gauss-Newton with the planes eliminated (docs/adjust.md). sensors: by scan, map frame, metres.
void add_patches(const std::vector<WeightedPatch>& patches, const std::vector<Eigen::Vector3d>& sensors,
                 PoseEquations* equations);

/// Half the cost of the patches: their weighted smallest eigenvalues.
double patch_cost(const std::vector<WeightedPatch>& patches);

}  // namespace cpplus
