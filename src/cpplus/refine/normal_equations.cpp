#include "cpplus/refine/normal_equations.h"

namespace cpplus {

void NormalEquations::clear(int num_unknowns) {
  size_ = num_unknowns;
  triplets_.clear();
  gradient_ = Eigen::VectorXd::Zero(size_);
}

void NormalEquations::add(const std::vector<int>& columns, const Eigen::MatrixXd& h, const Eigen::VectorXd& g) {
  const auto count = static_cast<Eigen::Index>(columns.size());
  for (Eigen::Index c = 0; c < count; ++c) {
    const int column = columns[static_cast<size_t>(c)];
    gradient_(column) += g(c);
    for (Eigen::Index r = 0; r < count; ++r) {
      const int row = columns[static_cast<size_t>(r)];
      if (row >= column) triplets_.emplace_back(row, column, h(r, c));
    }
  }
}

void NormalEquations::add_diagonal(int column, const Eigen::VectorXd& information, const Eigen::VectorXd& residual) {
  for (Eigen::Index k = 0; k < information.size(); ++k) {
    const int at = column + static_cast<int>(k);
    triplets_.emplace_back(at, at, information(k));
    gradient_(at) += information(k) * residual(k);
  }
}

void NormalEquations::add_linear(const std::vector<LinearBlock>& blocks, const Vector6d& residual,
                                 const Vector6d& sigmas) {
  const Vector6d w = sigmas.cwiseAbs2().cwiseInverse();
  for (const LinearBlock& x : blocks) {
    gradient_.segment(x.column, x.design.cols()) += x.design.transpose() * w.cwiseProduct(residual);
    for (const LinearBlock& y : blocks) {
      if (x.column >= y.column) add_block(x.column, y.column, x.design.transpose() * w.asDiagonal() * y.design);
    }
  }
}

void NormalEquations::add_block(int row, int column, const Eigen::MatrixXd& block) {
  for (int c = 0; c < block.cols(); ++c) {
    for (int r = 0; r < block.rows(); ++r) {
      if (row + r >= column + c) triplets_.emplace_back(row + r, column + c, block(r, c));
    }
  }
}

Eigen::SparseMatrix<double> NormalEquations::information() const {
  Eigen::SparseMatrix<double> matrix(size_, size_);
  matrix.setFromTriplets(triplets_.begin(), triplets_.end());
  return matrix;
}

void NormalEquations::factorise(const Eigen::SparseMatrix<double>& matrix) {
  if (factor_.rows() == 0) factor_.analyzePattern(matrix);
  factor_.factorize(matrix);
}

Eigen::VectorXd NormalEquations::step(double damping) {
  Eigen::SparseMatrix<double> damped = information();
  for (int i = 0; i < size_; ++i) damped.coeffRef(i, i) *= 1.0 + damping;
  factorise(damped);
  return -factor_.solve(gradient_);
}

SelectedInverse NormalEquations::inverse() {
  factorise(information());
  return SelectedInverse(factor_);
}

}  // namespace cpplus
