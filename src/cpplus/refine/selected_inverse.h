#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace cpplus {

/// The entries of the inverse of a sparse symmetric positive definite matrix where its Cholesky factor is not zero, in
/// about the time of the factorisation (Takahashi, Fagan and Chin 1973): variances and the covariances of what is
/// directly coupled, without the dense inverse.
class SelectedInverse {
 public:
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

  explicit SelectedInverse(const Factor& factor);

  /// Entry (row, column) of the inverse; it must not be zero in the matrix itself. 0 where the factor has no entry.
  double at(Eigen::Index row, Eigen::Index column) const;

 private:
  // In the order of the factor.
  double permuted(int row, int column) const;

  Eigen::VectorXi place_of_;       // row of the matrix -> row of the factor
  std::vector<int> column_begin_;  // of the strictly lower triangle
  std::vector<int> rows_;
  std::vector<double> values_;
  std::vector<double> diagonal_;
};

}  // namespace cpplus
