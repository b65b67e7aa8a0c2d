#include "cpplus/geometry/end_rate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

Eigen::VectorXd stamps(int count, double step_s, double jitter = 0.0) {
  Eigen::VectorXd t(count);
  for (int i = 0; i < count; ++i) t[i] = 5.0 + step_s * (i + jitter * std::sin(7.0 * i));
  return t;
}

TEST(EndRate, FourSamplesGiveTheKnownDifferences) {
  const Eigen::VectorXd weights = end_rate_weights(stamps(4, 0.5));
  const Eigen::Vector4d expected = Eigen::Vector4d(-11.0 / 6.0, 3.0, -1.5, 1.0 / 3.0) / 0.5;
  EXPECT_LT((weights - expected).norm(), 1e-9) << weights.transpose();
}

TEST(EndRate, CubicsAreExactFromEitherEndAndUnevenly) {
  for (const double step_s : {0.1, -0.1}) {
    const Eigen::VectorXd t = stamps(8, step_s, 0.2);
    const Eigen::VectorXd f = t.array().cube() - 2.0 * t.array();
    EXPECT_NEAR(end_rate_weights(t).dot(f), 3.0 * t[0] * t[0] - 2.0, 1e-7);
  }
}

TEST(EndRate, FewSamplesAPeriodAreEnough) {
  const double rate = 2.0 * M_PI * 1.8;  // rad/s: 5.6 samples a period
  for (double phase = 0.0; phase < 6.0; phase += 0.5) {
    const Eigen::VectorXd t = stamps(8, 0.1);
    const Eigen::VectorXd f = (rate * (t.array() - t[0]) + phase).sin();
    EXPECT_NEAR(end_rate_weights(t).dot(f) / rate, std::cos(phase), 0.06);
  }
}

TEST(EndRate, NoiseOfTheSamplesIsNotBlownUp) { EXPECT_LT(end_rate_weights(stamps(8, 1.0)).norm(), 6.0); }

}  // namespace
}  // namespace cpplus
