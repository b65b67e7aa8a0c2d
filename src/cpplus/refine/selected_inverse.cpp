#include "cpplus/refine/selected_inverse.h"

#include <algorithm>
#include <cassert>

namespace cpplus {

SelectedInverse::SelectedInverse(const Factor& factor) {
  const Eigen::SparseMatrix<double> lower = factor.matrixL();
  const Eigen::VectorXd d = factor.vectorD();
  const int size = static_cast<int>(lower.cols());
  place_of_ = factor.permutationP().size() == size ? Eigen::VectorXi(factor.permutationP().indices())
                                                   : Eigen::VectorXi::LinSpaced(size, 0, size - 1);
  std::vector<double> l;
  column_begin_.push_back(0);
  for (int column = 0; column < size; ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, column); it; ++it) {
      if (it.row() <= column) continue;
      rows_.push_back(static_cast<int>(it.row()));
      l.push_back(it.value());
    }
    column_begin_.push_back(static_cast<int>(rows_.size()));
  }
  values_.assign(l.size(), 0.0);
  diagonal_.assign(static_cast<size_t>(size), 0.0);
  for (int j = size - 1; j >= 0; --j) {
    const auto begin = static_cast<size_t>(column_begin_[static_cast<size_t>(j)]);
    const auto end = static_cast<size_t>(column_begin_[static_cast<size_t>(j) + 1]);
    double on_diagonal = 1.0 / d(j);
    for (size_t p = begin; p < end; ++p) {
      double sum = 0.0;
      for (size_t q = begin; q < end; ++q) sum += l[q] * permuted(rows_[p], rows_[q]);
      values_[p] = -sum;
      on_diagonal += l[p] * sum;
    }
    diagonal_[static_cast<size_t>(j)] = on_diagonal;
  }
}

double SelectedInverse::permuted(int row, int column) const {
  if (row == column) return diagonal_[static_cast<size_t>(row)];
  if (row < column) std::swap(row, column);
  const auto begin = rows_.begin() + column_begin_[static_cast<size_t>(column)];
  const auto end = rows_.begin() + column_begin_[static_cast<size_t>(column) + 1];
  const auto it = std::lower_bound(begin, end, row);
  return it == end || *it != row ? 0.0 : values_[static_cast<size_t>(it - rows_.begin())];
}

double SelectedInverse::at(Eigen::Index row, Eigen::Index column) const {
  return permuted(place_of_(row), place_of_(column));
}

}  // namespace cpplus
