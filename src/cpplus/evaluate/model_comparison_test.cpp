#include "cpplus/evaluate/model_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using testing::ElementsAre;

/// Cameras that look along +z from the given centres.
SparseModel model_of(const std::vector<std::pair<std::string, Eigen::Vector3d>>& centers) {
  SparseModel model;
  model.cameras.emplace(7u, Camera(CameraModel::kPinhole, 640, 480, {500.0, 500.0, 320.0, 240.0}));
  for (const auto& [name, center] : centers) {
    PosedImage image;
    image.id = static_cast<uint32_t>(model.images.size() + 1);
    image.name = name;
    image.camera_id = 7;
    image.camera_from_map = Rigid3{Eigen::Quaterniond::Identity(), -center};
    model.images.push_back(image);
  }
  return model;
}

/// One point 5 m in front of the camera, except for image "dark".
std::vector<Eigen::Vector3d> point_ahead(const PosedImage& image, const Camera&) {
  if (image.name == "dark") return {};
  return {camera_center(image.camera_from_map) + Eigen::Vector3d(0, 0, 5)};
}

TEST(CompareModels, MatchesByNameAndSummarizes) {
  const SparseModel reference = model_of({{"c", {2, 0, 0}}, {"a", {0, 0, 0}}, {"b", {1, 0, 0}}, {"lost", {9, 9, 9}}});
  const SparseModel estimate =
      model_of({{"a", {0.01, 0, 0}}, {"b", {1.04, 0, 0}}, {"c", {2, 0.1, 0}}, {"extra", {0, 0, 0}}});
  const ModelComparison comparison = compare_models(estimate, reference, point_ahead, {});
  ASSERT_EQ(comparison.images.size(), 3u);
  EXPECT_EQ(comparison.images[0].name, "a");
  EXPECT_NEAR(comparison.images[0].shift.mean_px, 1.0, 1e-9);  // 500 px * 0.01 m / 5 m
  EXPECT_NEAR(comparison.images[1].shift.mean_px, 4.0, 1e-9);
  EXPECT_NEAR(comparison.images[2].shift.mean_px, 10.0, 1e-9);
  EXPECT_NEAR(comparison.shift_px.median, 4.0, 1e-9);
  EXPECT_NEAR(comparison.shift_shares[2], 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(comparison.translation_m.mean, 0.05, 1e-12);
  EXPECT_NEAR(comparison.rotation_deg.max, 0.0, 1e-9);
  EXPECT_THAT(comparison.only_in_reference, ElementsAre("lost"));
  EXPECT_THAT(comparison.only_in_estimate, ElementsAre("extra"));
  EXPECT_EQ(comparison.checkerboard_px.count, 0u);
  EXPECT_NEAR(comparison.absolute[0].error->translation_m.rms, std::sqrt((0.01 * 0.01 + 0.04 * 0.04 + 0.1 * 0.1) / 3),
              1e-12);
  EXPECT_EQ(comparison.relative[0].error.translation_m.count, 2u);
  EXPECT_NEAR(comparison.relative[0].error.translation_m.max, std::hypot(0.04, 0.1), 1e-12);
}

TEST(CompareModels, ImagesWithoutVisiblePointsDoNotEnterTheShift) {
  const SparseModel reference = model_of({{"a", {0, 0, 0}}, {"dark", {1, 0, 0}}});
  const SparseModel estimate = model_of({{"a", {0.01, 0, 0}}, {"dark", {8, 0, 0}}});
  const ModelComparison comparison = compare_models(estimate, reference, point_ahead, {});
  EXPECT_EQ(comparison.shift_px.count, 1u);
  EXPECT_NEAR(comparison.shift_px.mean, 1.0, 1e-9);
  EXPECT_EQ(comparison.translation_m.count, 2u);
}

TEST(CompareModels, LeavesOutExcludedImages) {
  const SparseModel reference = model_of({{"a", {0, 0, 0}}, {"blurred", {1, 0, 0}}});
  const ModelComparison comparison = compare_models(reference, reference, point_ahead, {}, {"blurred"});
  EXPECT_EQ(comparison.images.size(), 1u);
  EXPECT_TRUE(comparison.only_in_reference.empty());
}

TEST(CompareModels, UsesTheEstimateForTheCheckerboards) {
  const SparseModel reference = model_of({{"a", {0, 0, 0}}});
  const SparseModel estimate = model_of({{"a", {0.02, 0, 0}}});
  const std::vector<Checkerboard> boards = {{"A", {{0, 0, 5}}, {{"a", {{320, 240}}}}}};
  EXPECT_NEAR(compare_models(estimate, reference, point_ahead, boards).checkerboard_px.mean, 2.0, 1e-9);
}

TEST(CompareModels, OfNothingInCommonHasNoFigures) {
  const ModelComparison comparison =
      compare_models(model_of({{"a", {0, 0, 0}}}), model_of({{"b", {0, 0, 0}}}), point_ahead, {});
  EXPECT_TRUE(comparison.images.empty());
  EXPECT_TRUE(std::isnan(comparison.shift_px.median));
  EXPECT_FALSE(comparison.absolute[0].error);
}

TEST(CompareModels, RejectsANameThatOccursTwiceAndACameraThatIsMissing) {
  const SparseModel one = model_of({{"a", {0, 0, 0}}});
  EXPECT_THROW(compare_models(one, model_of({{"a", {0, 0, 0}}, {"a", {1, 0, 0}}}), point_ahead, {}), Error);
  SparseModel without_camera = one;
  without_camera.cameras.clear();
  EXPECT_THROW(compare_models(one, without_camera, point_ahead, {}), Error);
}

}  // namespace
}  // namespace cpplus
