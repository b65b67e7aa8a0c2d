#include "cpplus/refine/normal_equations.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace cpplus {
namespace {

// x0 = 1 and x1 = 4 with information 2 and 3, tied by (x0 - x1 + 5)^2.
void fill_by_hand(NormalEquations* equations) {
  equations->clear(2);
  equations->add_diagonal(0, Eigen::Vector2d(2, 3), Eigen::Vector2d(-1, -4));  // at x = 0
  equations->add({1, 0}, Eigen::Matrix2d{{1, -1}, {-1, 1}}, Eigen::Vector2d(-5, 5));
}

TEST(NormalEquations, StepAndInverseByHand) {
  NormalEquations equations;
  fill_by_hand(&equations);
  // [3 -1; -1 4] x = -(3, -17)
  const Eigen::VectorXd x = equations.step(0.0);
  EXPECT_NEAR(x(0), 5.0 / 11.0, 1e-12);
  EXPECT_NEAR(x(1), 48.0 / 11.0, 1e-12);
  const SelectedInverse inverse = equations.inverse();
  EXPECT_NEAR(inverse.at(0, 0), 4.0 / 11.0, 1e-12);
  EXPECT_NEAR(inverse.at(1, 0), 1.0 / 11.0, 1e-12);
  EXPECT_NEAR(inverse.at(1, 1), 3.0 / 11.0, 1e-12);
  EXPECT_LT(equations.step(10.0).norm(), 0.2 * x.norm());
}

TEST(NormalEquations, AColumnThatIsNamedTwiceGetsBothParts) {
  NormalEquations equations;
  equations.clear(1);
  // (2 x + 3 x - 10)^2 as a term of two unknowns that are one.
  equations.add({0, 0}, Eigen::Matrix2d{{4, 6}, {6, 9}}, Eigen::Vector2d(-20, -30));
  EXPECT_NEAR(equations.step(0.0)(0), 2.0, 1e-12);
}

TEST(NormalEquations, LinearBlocksAreThoseOfTheDenseProblem) {
  const Matrix6d a = Matrix6d::Random() + 3 * Matrix6d::Identity();
  const Eigen::Matrix<double, 6, 2> b = Eigen::Matrix<double, 6, 2>::Random();
  const Vector6d residual = Vector6d::Random();
  Vector6d sigmas;
  sigmas << 1, 2, 3, 0.5, 0.2, 1;
  NormalEquations equations;
  equations.clear(8);
  equations.add_linear({{0, a}, {6, b}}, residual, sigmas);
  equations.add_diagonal(6, Eigen::Vector2d(1, 1), Eigen::Vector2d(0.3, -0.2));
  Eigen::Matrix<double, 8, 8> h = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 6, 8> design;
  design << a, b;
  const Vector6d w = sigmas.cwiseAbs2().cwiseInverse();
  h = design.transpose() * w.asDiagonal() * design;
  Eigen::Matrix<double, 8, 1> g = design.transpose() * w.cwiseProduct(residual);
  for (int k = 6; k < 8; ++k) h(k, k) += 1.0;
  g(6) += 0.3;
  g(7) -= 0.2;
  EXPECT_LT((equations.step(0.0) + h.inverse() * g).norm(), 1e-8);
  EXPECT_NEAR(equations.inverse().at(7, 2), h.inverse()(7, 2), 1e-8);
}

TEST(NormalEquations, ClearedTheyTakeOtherValuesInTheSamePlaces) {
  NormalEquations equations;
  fill_by_hand(&equations);
  equations.step(0.0);
  equations.clear(2);
  equations.add_diagonal(0, Eigen::Vector2d(1, 1), Eigen::Vector2d(-7, -8));
  equations.add({1, 0}, Eigen::Matrix2d::Zero(), Eigen::Vector2d::Zero());
  EXPECT_LT((equations.step(0.0) - Eigen::Vector2d(7, 8)).norm(), 1e-12);
}

}  // namespace
}  // namespace cpplus
