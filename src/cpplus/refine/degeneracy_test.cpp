#include "cpplus/refine/degeneracy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cpplus {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Vector6d sigmas() {
  Vector6d s;
  s << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;
  return s;
}

// Information of a measurement that is `ratio` times as informative as the prior, per component.
Matrix6d diagonal_information(const Vector6d& ratio) {
  return ratio.cwiseQuotient(sigmas().cwiseProduct(sigmas())).asDiagonal();
}

TEST(AnalyseInformation, ADiagonalMatrixByHand) {
  Vector6d ratio;
  ratio << 99, 24, 15, 0, 8, 3;
  const Degeneracy degeneracy = analyse_information(diagonal_information(ratio), sigmas());
  Vector6d ascending;
  ascending << 0, 3, 8, 15, 24, 99;
  EXPECT_LT((degeneracy.eigenvalues - ascending).norm(), 1e-9);
  EXPECT_THAT(degeneracy.weak_directions, ElementsAre("translation x"));
  // Prior and data together: variance = prior variance / (1 + ratio).
  const Vector6d variance = sigmas().cwiseProduct(sigmas()).cwiseQuotient((ratio.array() + 1.0).matrix());
  EXPECT_LT((degeneracy.covariance - Matrix6d(variance.asDiagonal())).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(AnalyseInformation, TheWorstDirectionComesFirst) {
  Vector6d ratio;
  ratio << 50, 0.5, 50, 50, 0.9, 0.1;
  const Degeneracy degeneracy = analyse_information(diagonal_information(ratio), sigmas());
  EXPECT_THAT(degeneracy.weak_directions, ElementsAre("translation z", "rotation y", "translation y"));
}

TEST(AnalyseInformation, NothingIsWeakWhereTheDataKnowsMoreThanThePrior) {
  EXPECT_THAT(analyse_information(diagonal_information(Vector6d::Constant(1.5)), sigmas()).weak_directions, IsEmpty());
  EXPECT_EQ(analyse_information(Matrix6d::Zero(), sigmas()).weak_directions.size(), 6u);
}

TEST(AnalyseInformation, WithoutDataThePriorIsTheCovariance) {
  const Degeneracy degeneracy = analyse_information(Matrix6d::Zero(), sigmas());
  const Vector6d variance = sigmas().cwiseProduct(sigmas());
  EXPECT_LT((degeneracy.covariance - Matrix6d(variance.asDiagonal())).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(AnalyseInformation, ComponentsThatMoveTogetherAreNamedTogether) {
  // Seen from afar, a step to the right looks like a turn: only the difference of the two is measured.
  Vector6d measured = Vector6d::Zero();
  measured(1) = 1.0 / 0.01;
  measured(3) = -1.0 / 0.1;
  Vector6d ratio = Vector6d::Constant(100);
  ratio(1) = ratio(3) = 0;
  const Matrix6d information = diagonal_information(ratio) + 100 * measured * measured.transpose();
  const Degeneracy degeneracy = analyse_information(information, sigmas());
  ASSERT_EQ(degeneracy.weak_directions.size(), 1u);
  EXPECT_THAT(degeneracy.weak_directions[0],
              AllOf(HasSubstr("rotation y"), HasSubstr("translation x"), Not(HasSubstr("z"))));
}

TEST(LeastKnownDirection, IsTheOneOfLargestVarianceInPriorUnits) {
  Vector6d variance = 0.01 * sigmas().cwiseProduct(sigmas());
  variance(1) *= 50.0;
  EXPECT_EQ(least_known_direction(variance.asDiagonal(), sigmas()), "rotation y");
  variance(5) *= 90.0;
  EXPECT_EQ(least_known_direction(variance.asDiagonal(), sigmas()), "translation z");
}

}  // namespace
}  // namespace cpplus
