#include "cpplus/pipeline/evaluate_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/core/option_list.h"

namespace cpplus {
namespace {

using testing::HasSubstr;

const std::string kScene = std::string(CPPLUS_DATA_DIR) + "/truth/corner_4/";

EvaluateOptions options_for(const std::string& estimate) {
  EvaluateOptions options;
  options.estimate = kScene + estimate;
  options.reference = kScene + "truth/on_map";
  options.depth = kScene + "truth/depth";
  options.depth_poses = kScene + "truth";
  options.checkerboards = kScene + "truth/checkerboards.json";
  options.exclude = kScene + "truth/blurred.txt";
  return options;
}

class EvaluateScene : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kScene)) GTEST_SKIP() << "no scenes in " << CPPLUS_DATA_DIR;
  }
};

TEST_F(EvaluateScene, TheReferenceAgainstItselfIsZero) {
  const ModelComparison comparison = evaluate_models(options_for("truth/on_map"));
  EXPECT_EQ(comparison.images.size(), 11u);  // 12, one of them blurred
  EXPECT_EQ(comparison.shift_px.count, 11u);
  EXPECT_NEAR(comparison.shift_px.max, 0.0, 1e-9);
  EXPECT_GT(comparison.images[0].shift.num_points, 40000u);
}

TEST_F(EvaluateScene, TheTruthIsOffByTheFloorThatTheSceneStates) {
  // map_floor.json: 0.52 to 0.62 px on the map's points; checkerboard corners are exact for the true poses.
  const ModelComparison comparison = evaluate_models(options_for("truth"));
  EXPECT_LT(comparison.shift_px.max, 0.7);
  EXPECT_EQ(comparison.checkerboard_px.count, 11u);
  EXPECT_LT(comparison.checkerboard_px.max, 0.01);
}

TEST_F(EvaluateScene, TheCoarseStartIsAsFarOffAsStated) {
  // Stated: 0.3 degrees and 3 cm RMS over the sequence, 4 to 9 px.
  const ModelComparison comparison = evaluate_models(options_for("coarse_small"));
  EXPECT_NEAR(comparison.rotation_deg.rms, 0.3, 0.03);
  EXPECT_NEAR(comparison.translation_m.rms, 0.03, 0.005);
  EXPECT_GT(comparison.shift_px.median, 3.0);
  EXPECT_LT(comparison.shift_px.median, 10.0);
}

TEST_F(EvaluateScene, TheJsonHoldsTheSameFiguresAndTheTableNamesTheImages) {
  const ModelComparison comparison = evaluate_models(options_for("coarse_small"));
  const auto json = nlohmann::json::parse(comparison_json(comparison));
  EXPECT_EQ(json["images"].size(), 11u);
  EXPECT_DOUBLE_EQ(json["summary"]["shift_px"]["median"].get<double>(), comparison.shift_px.median);
  EXPECT_DOUBLE_EQ(json["summary"]["shift_shares"]["under_5_px"].get<double>(), comparison.shift_shares[2]);
  EXPECT_NEAR(json["absolute"]["none"]["translation_m"]["rms"].get<double>(), comparison.translation_m.rms, 1e-12);
  EXPECT_THAT(comparison_table(comparison), HasSubstr("000011.jpg"));
}

TEST_F(EvaluateScene, TheMapsPointsGiveNearlyTheShiftOfTheExactRanges) {
  EvaluateOptions options = options_for("coarse_small");
  const double exact_px = evaluate_models(options).shift_px.median;
  options.depth.clear();
  options.depth_poses.clear();
  options.map = kScene + "map.pcd";
  EXPECT_NEAR(evaluate_models(options).shift_px.median, exact_px, 0.1 * exact_px);
}

TEST_F(EvaluateScene, WithoutRangesOrAMapThereIsNoShift) {
  EvaluateOptions options = options_for("coarse_small");
  options.depth.clear();
  options.depth_poses.clear();
  const ModelComparison comparison = evaluate_models(options);
  EXPECT_EQ(comparison.shift_px.count, 0u);
  EXPECT_TRUE(nlohmann::json::parse(comparison_json(comparison))["summary"]["shift_px"]["median"].is_null());
}

TEST_F(EvaluateScene, ModelsWithoutACommonImageAreAnError) {
  EvaluateOptions options = options_for("coarse_small");
  options.reference = std::string(CPPLUS_DATA_DIR) + "/recorded/pjlab_crosswalk_a/reference";
  options.exclude.clear();
  EXPECT_EQ(evaluate_models(options_for("coarse_small")).only_in_reference.size(), 0u);
  options.estimate = std::string(CPPLUS_DATA_DIR) + "/recorded/mlcc_hku_courtyard/reference";
  EXPECT_THROW(evaluate_models(options), Error);
}

TEST(EvaluateOptions, AreAllOnTheCommandLine) {
  EvaluateOptions options;
  std::vector<std::string> names;
  for (const OptionField& field : list_options(options)) names.push_back(field.path);
  EXPECT_THAT(names,
              testing::ElementsAre("estimate", "reference", "map", "depth", "depth_poses", "checkerboards", "exclude"));
}

TEST(EvaluateOptions, NameBothModelsAndNoPosesWithoutRanges) {
  EvaluateOptions options;
  EXPECT_THROW(options.validate(), UsageError);
  options.estimate = options.reference = "model";
  EXPECT_NO_THROW(options.validate());
  options.depth_poses = "model";
  EXPECT_THROW(options.validate(), UsageError);
}

}  // namespace
}  // namespace cpplus
