#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/selected_inverse.h"

namespace cpplus {

/// The normal equations H x = -g of a least-squares problem whose terms depend on few unknowns each. The terms are
/// added anew for each step of the solver, always in the same places: these are put in order once.
class NormalEquations {
 public:
  /// For so many unknowns, all zero; the places of an earlier use are kept.
  void clear(int num_unknowns);

  /// A term with information h and gradient g of the unknowns in `columns`; a column may be named twice.
  void add(const std::vector<int>& columns, const Eigen::MatrixXd& h, const Eigen::VectorXd& g);

  /// Independent numbers in successive columns: information and information times residual are added.
  void add_diagonal(int column, const Eigen::VectorXd& information, const Eigen::VectorXd& residual);

  struct LinearBlock {
    int column;  // the first of design.cols()
    Eigen::Matrix<double, 6, Eigen::Dynamic> design;
  };
  /// Six numbers that are linear in some blocks of unknowns, with their residuals now and their standard deviations.
  void add_linear(const std::vector<LinearBlock>& blocks, const Vector6d& residual, const Vector6d& sigmas);

  /// The x that solves (H + damping diag H) x = -g.
  Eigen::VectorXd step(double damping);
  SelectedInverse inverse();

 private:
  void add_block(int row, int column, const Eigen::MatrixXd& block);
  Eigen::SparseMatrix<double> information() const;
  void factorise(const Eigen::SparseMatrix<double>& matrix);

  int size_ = 0;
  std::vector<Eigen::Triplet<double>> triplets_;  // of the lower triangle
  Eigen::VectorXd gradient_;
  SelectedInverse::Factor factor_;
};

}  // namespace cpplus
