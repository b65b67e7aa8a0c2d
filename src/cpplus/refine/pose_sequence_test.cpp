#include "cpplus/refine/pose_sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"
#include "cpplus/refine/pose_search.h"

namespace cpplus {
namespace {

const Vector6d kPrior = PosePrior().sigmas();

// Images one second apart whose corrections are known to a tenth of the prior; `correction_of` gives the truth.
template <typename Function>
std::vector<PoseCorrection> sequence(size_t count, Function correction_of) {
  std::vector<PoseCorrection> corrections(count);
  Random random(5);
  for (size_t i = 0; i < count; ++i) {
    const Vector6d sigmas = 0.1 * kPrior;
    corrections[i].time = static_cast<double>(i);
    corrections[i].correction = correction_of(i);
    for (int k = 0; k < 6; ++k) corrections[i].correction(k) += sigmas(k) * random.normal();
    corrections[i].information = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
    corrections[i].usable = true;
  }
  return corrections;
}

Vector6d common_error() {
  Vector6d error;
  error << 0.8, -0.5, 0.3, 0.6, -0.9, 0.2;
  return error.cwiseProduct(kPrior);
}

double in_prior_sigmas(const Vector6d& difference) { return difference.cwiseQuotient(kPrior).cwiseAbs().maxCoeff(); }

TEST(PredictCorrections, AnErrorCommonToAllPredictsTheImageThatFailed) {
  std::vector<PoseCorrection> corrections = sequence(12, [](size_t) { return common_error(); });
  corrections[5] = PoseCorrection();
  corrections[5].time = 5.0;
  const std::vector<PosePrediction> predictions = predict_corrections(corrections, kPrior, {});
  ASSERT_EQ(predictions.size(), 12u);
  EXPECT_LT(in_prior_sigmas(predictions[5].mean - common_error()), 0.15);
  EXPECT_LT(in_prior_sigmas(predictions[5].sigmas), 0.5);
  EXPECT_EQ(predictions[5].consistency, 0.0);
}

TEST(PredictCorrections, AnImageThatContradictsItsNeighboursStandsOutAndMisleadsNone) {
  std::vector<PoseCorrection> corrections = sequence(12, [](size_t) { return common_error(); });
  corrections[7].correction = -2.0 * common_error();
  const std::vector<PosePrediction> predictions = predict_corrections(corrections, kPrior, {});
  ASSERT_EQ(predictions.size(), 12u);
  for (size_t i = 0; i < 12; ++i) {
    EXPECT_LT(in_prior_sigmas(predictions[i].mean - common_error()), 0.3) << i;
    EXPECT_TRUE(i == 7 || predictions[i].consistency < predictions[7].consistency / 3) << i;
  }
}

TEST(PredictCorrections, ADriftIsFollowed) {
  const auto drift = [](size_t i) { return Vector6d(std::sin(0.2 * static_cast<double>(i)) * common_error()); };
  std::vector<PoseCorrection> corrections = sequence(30, drift);
  corrections[14].usable = false;
  corrections[14].information.setZero();
  corrections[14].correction.setZero();
  const std::vector<PosePrediction> predictions = predict_corrections(corrections, kPrior, {});
  ASSERT_EQ(predictions.size(), 30u);
  EXPECT_LT(in_prior_sigmas(predictions[14].mean - drift(14)), 0.3);
}

TEST(PredictCorrections, IndependentErrorsPredictLittle) {
  Random random(9);
  const std::vector<PoseCorrection> corrections = sequence(30, [&](size_t) {
    Vector6d error;
    for (int k = 0; k < 6; ++k) error(k) = kPrior(k) * random.normal();
    return error;
  });
  const std::vector<PosePrediction> predictions = predict_corrections(corrections, kPrior, {});
  ASSERT_EQ(predictions.size(), 30u);
  for (size_t i = 0; i < 30; ++i) EXPECT_GT(predictions[i].sigmas.cwiseQuotient(kPrior).minCoeff(), 0.3) << i;
}

TEST(PredictCorrections, TooFewImagesPredictNothing) {
  std::vector<PoseCorrection> corrections = sequence(12, [](size_t) { return common_error(); });
  for (size_t i = 3; i < 12; ++i) corrections[i].usable = false;
  EXPECT_TRUE(predict_corrections(corrections, kPrior, {}).empty());
  EXPECT_TRUE(predict_corrections({}, kPrior, {}).empty());
}

TEST(PredictCorrections, SeveralImagesOfOneInstantAreNoDivisionByZero) {
  std::vector<PoseCorrection> corrections = sequence(8, [](size_t) { return common_error(); });
  for (PoseCorrection& correction : corrections) correction.time = 3.0;
  const std::vector<PosePrediction> predictions = predict_corrections(corrections, kPrior, {});
  ASSERT_EQ(predictions.size(), 8u);
  for (const PosePrediction& prediction : predictions) {
    EXPECT_TRUE(prediction.mean.allFinite());
    EXPECT_TRUE(prediction.sigmas.allFinite());
    EXPECT_LT(in_prior_sigmas(prediction.mean - common_error()), 0.3);
  }
}

TEST(PoseSequenceOptions, ValuesOutOfRangeAreErrors) {
  PoseSequenceOptions options;
  EXPECT_NO_THROW(options.validate());
  options.min_images = 2;
  EXPECT_THROW(options.validate(), Error);
}

}  // namespace
}  // namespace cpplus
