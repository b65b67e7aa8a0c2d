#include "cpplus/refine/drift_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

// Statistics of three axes that are known exactly, drawn from a process.
struct Drawn {
  std::vector<double> first;
  std::vector<DriftPair> pairs;
};

Drawn draw(const DriftProcess& process, int count, double gap, Random* random) {
  Drawn drawn;
  double x[3], before[3];
  for (int k = 0; k < count; ++k) {
    DriftPair pair{gap, 0, 0, 0};
    double square = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      before[axis] = x[axis];
      x[axis] = k == 0 ? process.sigma * random->normal()
                       : process.correlation(gap) * before[axis] + process.innovation_sigma(gap) * random->normal();
      square += x[axis] * x[axis] / 3.0;
      if (k == 0) continue;
      pair.before_before += before[axis] * before[axis] / 3.0;
      pair.before_now += before[axis] * x[axis] / 3.0;
      pair.now_now += x[axis] * x[axis] / 3.0;
    }
    if (k == 0) {
      drawn.first.push_back(square);
    } else {
      drawn.pairs.push_back(pair);
    }
  }
  return drawn;
}

TEST(DriftProcess, CorrelationFallsToOneOverEAfterItsMemory) {
  const DriftProcess process{0.5, 2.0};
  EXPECT_NEAR(process.correlation(2.0), std::exp(-1.0), 1e-12);
  EXPECT_NEAR(process.innovation_sigma(2.0), 0.5 * std::sqrt(1.0 - std::exp(-2.0)), 1e-12);
  EXPECT_EQ((DriftProcess{0.5, 0.0}).correlation(1.0), 0.0);
  EXPECT_NEAR(process.innovation_sigma(100.0), 0.5, 1e-12);
}

TEST(MostLikelyDrift, IndependentErrorsHaveNoMemory) {
  Random random(1);
  const Drawn drawn = draw({0.4, 0.0}, 300, 1.0, &random);
  const DriftProcess found = most_likely_drift(drawn.first, drawn.pairs, 0.01, 2.0);
  EXPECT_LE(found.memory, 0.3);
  EXPECT_NEAR(found.sigma, 0.4, 0.03);
}

TEST(MostLikelyDrift, SizeAndMemoryOfADriftAreFound) {
  Random random(2);
  for (const double gap : {0.5, 1.0}) {
    const Drawn drawn = draw({0.4, 4.5}, 2000, gap, &random);
    const DriftProcess found = most_likely_drift(drawn.first, drawn.pairs, 0.01, 2.0);
    EXPECT_GE(found.memory, 3.0) << gap;
    EXPECT_LE(found.memory, 7.0) << gap;
    EXPECT_NEAR(found.sigma, 0.4, 0.06) << gap;
  }
}

TEST(MostLikelyDrift, AWrongImageDoesNotDecide) {
  Random random(3);
  Drawn drawn = draw({0.2, 3.0}, 40, 1.0, &random);
  // Image 10 jumps by 20 sigmas and back.
  drawn.pairs[9] = {1.0, 0.04, 0.0, 16.0};
  drawn.pairs[10] = {1.0, 16.0, 0.0, 0.04};
  EXPECT_LT(most_likely_drift(drawn.first, drawn.pairs, 0.01, 2.0).sigma, 0.4);
}

TEST(MostLikelyDrift, StaysWithinItsBounds) {
  EXPECT_EQ(most_likely_drift({0.0}, {{1.0, 0.0, 0.0, 0.0}}, 0.03, 2.0).sigma, 0.03);
  EXPECT_EQ(most_likely_drift({100.0}, {{1.0, 100.0, 0.0, 100.0}}, 0.03, 2.0).sigma, 2.0);
  EXPECT_EQ(most_likely_drift({}, {}, 0.03, 2.0).sigma, 0.03);
}

}  // namespace
}  // namespace cpplus
