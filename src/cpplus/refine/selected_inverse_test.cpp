#include "cpplus/refine/selected_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

// A band along the diagonal, and some full rows and columns at the end: images in sequence and what they share.
Sparse band_and_arrow(int size, int band, int arrow, uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < r; ++c) {
      if (r - c > band && r < size - arrow) continue;
      dense(r, c) = dense(c, r) = random.normal();
    }
  }
  // Rows that outweigh the rest of themselves make it positive definite; the scales differ as rad and metres do.
  dense.diagonal() = dense.cwiseAbs().rowwise().sum().array() + 0.1;
  Eigen::VectorXd scales(size);
  for (int i = 0; i < size; ++i) scales(i) = std::pow(10.0, random.uniform(-2, 2));
  return Eigen::MatrixXd(scales.asDiagonal() * dense * scales.asDiagonal()).sparseView();
}

void expect_entries_of_the_dense_inverse(const Sparse& matrix) {
  const SelectedInverse selected{SelectedInverse::Factor(matrix)};
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(matrix).inverse();
  for (int column = 0; column < matrix.outerSize(); ++column) {
    for (Sparse::InnerIterator it(matrix, column); it; ++it) {
      const double scale = std::sqrt(inverse(it.row(), it.row()) * inverse(column, column));
      EXPECT_NEAR(selected.at(it.row(), column), inverse(it.row(), column), 1e-10 * scale) << it.row() << " " << column;
    }
  }
}

TEST(SelectedInverse, ByHand) {
  // [2 1; 1 3]^-1 = [3 -1; -1 2] / 5.
  Sparse matrix(2, 2);
  matrix.insert(0, 0) = 2;
  matrix.insert(1, 0) = matrix.insert(0, 1) = 1;
  matrix.insert(1, 1) = 3;
  const SelectedInverse inverse{SelectedInverse::Factor(matrix)};
  EXPECT_NEAR(inverse.at(0, 0), 0.6, 1e-15);
  EXPECT_NEAR(inverse.at(1, 1), 0.4, 1e-15);
  EXPECT_NEAR(inverse.at(1, 0), -0.2, 1e-15);
  EXPECT_NEAR(inverse.at(0, 1), -0.2, 1e-15);
}

TEST(SelectedInverse, OfOneNumberAndOfTheIdentity) {
  Sparse one(1, 1);
  one.insert(0, 0) = 8.0;
  EXPECT_DOUBLE_EQ(SelectedInverse{SelectedInverse::Factor(one)}.at(0, 0), 0.125);

  Sparse identity(7, 7);
  identity.setIdentity();
  const SelectedInverse inverse{SelectedInverse::Factor(identity)};
  for (int r = 0; r < 7; ++r) {
    for (int c = 0; c < 7; ++c) EXPECT_EQ(inverse.at(r, c), r == c ? 1.0 : 0.0) << r << " " << c;
  }
}

TEST(SelectedInverse, AgreesWithTheDenseInverse) {
  uint64_t seed = 0;
  for (const int size : {2, 3, 10, 40, 130}) {
    for (const int band : {0, 1, 6}) {
      for (const int arrow : {0, 1, 7}) {
        if (arrow >= size) continue;
        SCOPED_TRACE(testing::Message() << size << " rows, band " << band << ", arrow " << arrow);
        expect_entries_of_the_dense_inverse(band_and_arrow(size, band, arrow, ++seed));
      }
    }
  }
}

TEST(SelectedInverse, AgreesWithTheDenseInverseOfAnyPattern) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(60, 60);
    for (int k = 0; k < 150; ++k) {
      const auto r = static_cast<Eigen::Index>(random.below(60)), c = static_cast<Eigen::Index>(random.below(60));
      dense(r, c) = dense(c, r) = random.normal();
    }
    dense.diagonal() = dense.cwiseAbs().rowwise().sum().array() + 0.1;
    expect_entries_of_the_dense_inverse(dense.sparseView());
  }
}

}  // namespace
}  // namespace cpplus
