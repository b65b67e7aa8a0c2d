#include "cpplus/refine/nelder_mead.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cpplus {
namespace {

const Vector6d kTruth = (Vector6d() << 0.3, -0.2, 0.1, 1.5, -2.0, 0.7).finished();

// A bowl whose axes are turned and of different length.
double bowl(const Vector6d& x) {
  const Vector6d d = x - kTruth;
  double sum = 2.0;
  for (int i = 0; i < 6; ++i) sum += (i + 1) * std::pow(d(i) + 0.4 * d((i + 1) % 6), 2);
  return sum;
}

TEST(NelderMead, FindsTheBottomOfABowl) {
  NelderMeadOptions options;
  options.max_evaluations = 3000;
  options.min_size = 1e-7;
  const NelderMeadResult result = minimise_nelder_mead(bowl, Vector6d::Zero(), Vector6d::Constant(0.5), options);
  EXPECT_LT((result.x - kTruth).norm(), 1e-4);
  EXPECT_NEAR(result.cost, 2.0, 1e-7);
}

TEST(NelderMead, StopsAtTheLastEvaluationAndIsNeverWorseThanTheStart) {
  NelderMeadOptions options;
  options.max_evaluations = 8;
  int calls = 0;
  const auto counted = [&](const Vector6d& x) {
    ++calls;
    return bowl(x);
  };
  const NelderMeadResult result = minimise_nelder_mead(counted, kTruth, Vector6d::Constant(0.5), options);
  EXPECT_EQ(result.evaluations, calls);
  EXPECT_LE(calls, 8 + 8) << "one step may end in a shrink";
  EXPECT_EQ(result.x, kTruth);
}

TEST(NelderMead, NotANumberIsInfinitelyBad) {
  const auto half = [](const Vector6d& x) { return x(0) > 0.1 ? std::numeric_limits<double>::quiet_NaN() : bowl(x); };
  const NelderMeadResult result = minimise_nelder_mead(half, Vector6d::Zero(), Vector6d::Constant(0.5), {});
  EXPECT_LE(result.x(0), 0.1);
  EXPECT_LT(result.cost, bowl(Vector6d::Zero()));
}

}  // namespace
}  // namespace cpplus
