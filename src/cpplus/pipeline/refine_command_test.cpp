#include "cpplus/pipeline/refine_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/evaluate_command.h"
#include "cpplus/pipeline/write_world.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string bytes_of_file(const fs::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

SimulateOptions small_world(int images) {
  SimulateOptions options;
  options.width = 480;
  options.height = 360;
  options.images = images;
  options.blurred = 0;
  options.moving = false;
  options.scans = 8;
  options.lidar.azimuth_steps = 600;
  options.lidar.rings = 32;
  options.render.samples_per_pixel = 2;
  return options;
}

/// A small room with six images, one of them spoiled in each way that may happen:
/// 000001 is not a JPEG, 000002 has another size than its camera, 000003 stands outside the map.
class RefineCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = fs::path(testing::TempDir()) / ("refine_command_test_" + std::to_string(getpid()));
    simulate(small_world(6), world_.string());

    std::ofstream(world_ / "images/000001.jpg") << "this is no JPEG";
    write_png((world_ / "small.png").string(), ColorImage(160, 120));
    fs::rename(world_ / "small.png", world_ / "images/000002.jpg");
    SparseModel model = read_sparse_model((world_ / "coarse_medium").string());
    model.images[3].camera_from_map.translation += Eigen::Vector3d(500, 500, 500);
    write_sparse_model_text((world_ / "coarse").string(), model);
    result_ = run("out", 2);
    report_ = nlohmann::json::parse(std::ifstream(world_ / "out/report.json"));
  }

  static void TearDownTestSuite() {
    fs::remove_all(world_);
    set_num_threads(0);
  }

  static RefineCommandOptions options_for(const std::string& out) {
    RefineCommandOptions options;
    options.map = (world_ / "map.pcd").string();
    options.images = (world_ / "images").string();
    options.poses = (world_ / "coarse").string();
    options.out = (world_ / out).string();
    return options;
  }

  static RefineSummary run(const std::string& out, int threads) {
    set_num_threads(threads);
    return refine_command(options_for(out));
  }

  static void expect_a_row_for_every_image();
  static void expect_good_images_nearer_to_the_truth();
  static void expect_bad_images_named();
  static void expect_all_keys_in_the_report();
  static void expect_what_the_images_share();

  static const nlohmann::json& image(size_t i) { return report_["images"][i]; }

  static fs::path world_;
  static RefineSummary result_;
  static nlohmann::json report_;
};

fs::path RefineCommand::world_;
RefineSummary RefineCommand::result_;
nlohmann::json RefineCommand::report_;

void RefineCommand::expect_a_row_for_every_image() {
  const SparseModel coarse = read_sparse_model((world_ / "coarse").string());
  const SparseModel refined = read_sparse_model((world_ / "out/sparse").string());
  ASSERT_EQ(refined.images.size(), 6u);
  ASSERT_EQ(report_["images"].size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(refined.images[i].name, coarse.images[i].name);
    EXPECT_EQ(image(i)["name"], coarse.images[i].name);
    const double change = camera_difference(coarse.images[i].camera_from_map, refined.images[i].camera_from_map).norm();
    if (image(i)["status"] == "refined") {
      EXPECT_GT(change, 1e-6) << i;
      EXPECT_EQ(image(i)["reason"], "") << i;
    } else {
      EXPECT_LT(change, 1e-9) << i;
      EXPECT_NE(image(i)["reason"], "") << i;
    }
  }
  EXPECT_EQ(refined.cameras.at(1).params(), coarse.cameras.at(1).params());
}

void RefineCommand::expect_good_images_nearer_to_the_truth() {
  EXPECT_GE(result_.num_refined, 2u);
  EvaluateOptions options;
  options.reference = (world_ / "truth/on_map").string();
  options.depth = (world_ / "truth/depth").string();
  options.depth_poses = (world_ / "truth").string();
  options.estimate = (world_ / "coarse").string();
  const ModelComparison before = evaluate_models(options);
  options.estimate = (world_ / "out/sparse").string();
  const ModelComparison after = evaluate_models(options);
  double sum_before = 0.0;
  double sum_after = 0.0;
  for (size_t i : {0, 4, 5}) {
    if (image(i)["status"] != "refined") continue;
    sum_before += before.images[i].shift.mean_px;
    sum_after += after.images[i].shift.mean_px;
    EXPECT_LT(after.images[i].shift.mean_px, before.images[i].shift.mean_px + 1.0) << i;
  }
  EXPECT_LT(sum_after, 0.7 * sum_before);
}

void RefineCommand::expect_bad_images_named() {
  EXPECT_EQ(image(1)["status"], "unreadable");
  EXPECT_THAT(image(1)["reason"].get<std::string>(), HasSubstr("000001.jpg"));
  EXPECT_EQ(image(2)["status"], "unreadable");
  EXPECT_THAT(image(2)["reason"].get<std::string>(), HasSubstr("160x120"));
  EXPECT_EQ(image(3)["status"], "outside_map");
  EXPECT_EQ(result_.num_images, 6u);
  EXPECT_EQ(result_.num_unreadable, 2u);
  EXPECT_EQ(result_.num_outside_map, 1u);
  EXPECT_EQ(result_.num_refined + result_.num_kept_coarse + result_.num_blurred, 3u);
}

void RefineCommand::expect_all_keys_in_the_report() {
  for (const char* key : {"version", "options", "map", "shared", "images"}) EXPECT_TRUE(report_.contains(key)) << key;
  EXPECT_EQ(report_["options"]["refine.max_iterations"], RefinePoseOptions().max_iterations);
  for (const nlohmann::json& row : report_["images"]) {
    for (const char* key :
         {"name", "status", "reason", "before", "after", "held_out_before", "held_out_after", "map_edges", "samples",
          "matches", "iterations", "milliseconds", "covariance", "eigenvalues", "weak_directions"}) {
      EXPECT_TRUE(row.contains(key)) << row["name"] << " " << key;
    }
    for (const char* residual : {"before", "after", "held_out_before", "held_out_after"}) {
      for (const char* key : {"median_px", "rms_px", "inlier_share"}) EXPECT_TRUE(row[residual].contains(key)) << key;
    }
    ASSERT_EQ(row["covariance"].size(), 6u);
    EXPECT_EQ(row["covariance"][5].size(), 6u);
    EXPECT_EQ(row["eigenvalues"].size(), 6u);
    EXPECT_TRUE(row["weak_directions"].is_array());
    EXPECT_TRUE(row["milliseconds"].contains("total"));
  }
  for (size_t i : {0, 4, 5}) {
    EXPECT_GT(image(i)["samples"], 0) << i;
    EXPECT_GT(image(i)["milliseconds"]["total"], 0.0) << i;
    EXPECT_GE(image(i)["milliseconds"].size(), 4u) << i;
  }
}

void RefineCommand::expect_what_the_images_share() {
  ASSERT_EQ(report_["shared"].size(), 1u) << "one camera";
  const nlohmann::json& shared = report_["shared"]["1"];
  EXPECT_EQ(shared["images"], 6);
  EXPECT_EQ(shared["time_offset_s"], 0.0) << "without stamps there is nothing to find it by";
  EXPECT_NEAR(shared["time_offset_sigma_s"].get<double>(), JointOptions().time_offset_sigma_s, 1e-9);
  ASSERT_EQ(shared["extrinsic"].size(), 6u);
  ASSERT_EQ(shared["extrinsic_sigmas"].size(), 6u);
  for (const nlohmann::json& sigma : shared["extrinsic_sigmas"]) EXPECT_GT(sigma.get<double>(), 0.0);
}

// One test, as each test is a process of its own that simulates the world anew.
TEST_F(RefineCommand, RefinesTheGoodImagesAndNamesTheBadOnes) {
  expect_a_row_for_every_image();
  expect_good_images_nearer_to_the_truth();
  expect_bad_images_named();
  expect_all_keys_in_the_report();
  expect_what_the_images_share();
}

/// The mean over the images of how far a model's surfaces are seen from where they should be, pixels.
double mean_shift_px(const fs::path& world, const fs::path& model) {
  EvaluateOptions options;
  options.reference = (world / "truth/on_map").string();
  options.depth = (world / "truth/depth").string();
  options.depth_poses = (world / "truth").string();
  options.estimate = model.string();
  double sum = 0.0;
  const ModelComparison comparison = evaluate_models(options);
  for (const auto& image : comparison.images) sum += image.shift.mean_px;
  return sum / static_cast<double>(comparison.images.size());
}

RefineCommandOptions joint_options(const fs::path& world, const std::string& out) {
  RefineCommandOptions options;
  options.map = (world / "map.pcd").string();
  options.images = (world / "images").string();
  options.poses = (world / "coarse_medium").string();
  options.stamps = (world / "stamps.txt").string();
  options.out = (world / out).string();
  return options;
}

TEST(RefineCommandJoint, ImagesTogetherFindMoreThanEachAlone) {
  const fs::path world = fs::path(testing::TempDir()) / ("refine_command_joint_" + std::to_string(getpid()));
  simulate(small_world(8), world.string());

  refine_command(joint_options(world, "together"));
  RefineCommandOptions one_by_one = joint_options(world, "alone");
  one_by_one.joint = false;
  refine_command(one_by_one);

  const double together = mean_shift_px(world, world / "together/sparse");
  const double alone = mean_shift_px(world, world / "alone/sparse");
  EXPECT_LT(alone, 0.5 * mean_shift_px(world, world / "coarse_medium"));
  EXPECT_LT(together, 0.9 * alone);
  const auto report = nlohmann::json::parse(std::ifstream(world / "together/report.json"));
  const nlohmann::json& shared = report["shared"]["1"];
  EXPECT_EQ(shared["images"], 8);
  EXPECT_LT(shared["time_offset_sigma_s"].get<double>(), JointOptions().time_offset_sigma_s);
  EXPECT_TRUE(nlohmann::json::parse(std::ifstream(world / "alone/report.json"))["shared"].empty());
  fs::remove_all(world);
}

TEST(RefineCommandJoint, IntensitiesAreFoundWhereTheMapHasThemUnlessSwitchedOff) {
  const fs::path world = fs::path(testing::TempDir()) / ("refine_command_intensities_" + std::to_string(getpid()));
  simulate(small_world(6), world.string());
  const auto matches = [&](const RefineCommandOptions& options) {
    refine_command(options);
    int count = 0;
    const auto report = nlohmann::json::parse(std::ifstream(fs::path(options.out) / "report.json"));
    for (const nlohmann::json& image : report["images"]) {
      count += image["intensities"]["matches"].get<int>();
      if (image["intensities"]["matches"] == 0) continue;
      EXPECT_LT(image["intensities"]["after_median_px"], image["intensities"]["before_median_px"]) << image["name"];
    }
    return count;
  };
  EXPECT_GT(matches(joint_options(world, "on")), 30);
  RefineCommandOptions off = joint_options(world, "off");
  off.stages.intensities.enabled = false;
  EXPECT_EQ(matches(off), 0);
  EXPECT_LT(mean_shift_px(world, world / "on/sparse"), mean_shift_px(world, world / "off/sparse"));
  fs::remove_all(world);
}

/// A sharp image of no room: bars at random. Few hold nothing for patches either.
ColorImage bars(int width, int height, int count, uint64_t seed) {
  Random random(seed);
  ColorImage image(width, height);
  for (int k = 0; k < count; ++k) {
    const auto gray = static_cast<uint8_t>(random.uniform(0, 255));
    const int x0 = static_cast<int>(random.uniform(0, width - 60));
    const int y0 = static_cast<int>(random.uniform(0, height - 60));
    const int x1 = x0 + static_cast<int>(random.uniform(5, 60));
    const int y1 = y0 + static_cast<int>(random.uniform(5, 60));
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) image.at(x, y) = {gray, gray, gray};
    }
  }
  return image;
}

TEST(RefineCommandJoint, AnImageThatShowsLittleIsPlacedByTheOthersUnlessMostDo) {
  const fs::path world = fs::path(testing::TempDir()) / ("refine_command_placed_" + std::to_string(getpid()));
  simulate(small_world(8), world.string());
  const auto spoil = [&](int i, int count) {
    const std::string name = "00000" + std::to_string(i);
    write_png((world / "images" / (name + ".png")).string(), bars(480, 360, count, static_cast<uint64_t>(i)));
    fs::rename(world / "images" / (name + ".png"), world / "images" / (name + ".jpg"));
  };
  const auto reports = [&](const std::string& out) {
    refine_command(joint_options(world, out));
    return nlohmann::json::parse(std::ifstream(world / out / "report.json"))["images"];
  };
  spoil(4, 120);  // shows something else, also to patches
  EXPECT_EQ(reports("other")[4]["status"], "kept_coarse");
  spoil(4, 6);
  const nlohmann::json one = reports("one");
  EXPECT_EQ(one[4]["status"], "refined") << one[4]["reason"];
  EXPECT_EQ(one[4]["reason"], "placed by the other images");
  for (const size_t i : {0, 1, 2, 3, 5, 6, 7}) EXPECT_NE(one[i]["reason"], "placed by the other images") << i;
  const SparseModel truth = read_sparse_model((world / "truth/on_map").string());
  const auto distance_m = [&](const fs::path& model) {
    const Rigid3 pose = read_sparse_model((world / model).string()).images[4].camera_from_map;
    return (camera_center(pose) - camera_center(truth.images[4].camera_from_map)).norm();
  };
  EXPECT_LT(distance_m("one/sparse"), 0.5 * distance_m("coarse_medium"));

  for (const int i : {0, 1, 2, 6, 7}) spoil(i, 6);
  for (const nlohmann::json& report : reports("most")) {
    EXPECT_NE(report["reason"], "placed by the other images") << report["name"];
  }
  fs::remove_all(world);
}

TEST_F(RefineCommand, OneThreadAndTwoWriteTheSameBytes) {
  run("one_thread", 1);
  for (const char* file : {"sparse/images.txt", "sparse/cameras.txt", "sparse/points3D.txt"}) {
    const std::string bytes = bytes_of_file(world_ / "one_thread" / file);
    EXPECT_FALSE(bytes.empty()) << file;
    EXPECT_EQ(bytes, bytes_of_file(world_ / "out" / file)) << file;
  }
}

TEST_F(RefineCommand, OnlyRefinedLeavesTheOthersOutAndOverlaysAreWrittenOnlyWhereAskedFor) {
  EXPECT_FALSE(fs::exists(world_ / "pictures"));
  RefineCommandOptions options = options_for("only_refined");
  options.only_refined = true;
  options.debug_images = (world_ / "pictures").string();
  const RefineSummary summary = refine_command(options);
  const SparseModel model = read_sparse_model(options.out + "/sparse");
  EXPECT_EQ(model.images.size(), summary.num_refined);
  for (const PosedImage& posed : model.images) {
    EXPECT_NE(posed.name, "000001.jpg");
    EXPECT_NE(posed.name, "000003.jpg");
  }
  EXPECT_EQ(nlohmann::json::parse(std::ifstream(options.out + "/report.json"))["images"].size(), 6u);
  const ColorImage overlay = read_color_image((world_ / "pictures/000000.jpg.png").string());
  EXPECT_GE(overlay.height, 360);
  EXPECT_FALSE(fs::exists(world_ / "pictures/000001.jpg.png"));
}

// One test, as each test is a process of its own that simulates the world anew.
TEST_F(RefineCommand, OtherMethodsJudgeEachImageByTheirOwnFigure) {
  RefineCommandOptions options = options_for("none");
  options.method = "none";
  EXPECT_EQ(refine_command(options).num_kept_coarse, 6u);
  const SparseModel coarse = read_sparse_model((world_ / "coarse").string());
  const SparseModel copied = read_sparse_model((world_ / "none/sparse").string());
  ASSERT_EQ(copied.images.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_LT(camera_difference(coarse.images[i].camera_from_map, copied.images[i].camera_from_map).norm(), 1e-12) << i;
  }

  const double start_px = mean_shift_px(world_, world_ / "coarse");
  for (const std::string method : {"lines", "nid"}) {
    options = options_for(method);
    options.method = method;
    const RefineSummary summary = refine_command(options);
    EXPECT_EQ(summary.num_unreadable, 2u) << method;
    EXPECT_EQ(summary.num_outside_map, 1u) << method;
    EXPECT_GE(summary.num_refined, 1u) << method;
    EXPECT_LT(mean_shift_px(world_, world_ / method / "sparse"), start_px) << method;
    const auto report = nlohmann::json::parse(std::ifstream(world_ / method / "report.json"));
    EXPECT_EQ(report["options"]["method"], method);
    EXPECT_TRUE(report["shared"].empty()) << method << " looks at each image alone";
    for (const nlohmann::json& row : report["images"]) {
      if (row["status"] != "refined") continue;
      const nlohmann::json& figures = method == "lines" ? row : row["nid"];
      const char* key = method == "lines" ? "/rms_px" : "";
      EXPECT_LT(figures.at(nlohmann::json::json_pointer("/after" + std::string(key))),
                figures.at(nlohmann::json::json_pointer("/before" + std::string(key))))
          << method;
    }
  }
}

TEST_F(RefineCommand, NidNeedsIntensities) {
  PointCloud cloud = read_point_cloud((world_ / "map.pcd").string());
  cloud.intensities.clear();
  RefineCommandOptions options = options_for("no_intensity");
  options.map = (world_ / "plain.pcd").string();
  options.method = "nid";
  write_point_cloud(options.map, cloud);
  EXPECT_EQ(refine_command(options).num_refined, 0u);
  const auto report = nlohmann::json::parse(std::ifstream(options.out + "/report.json"));
  EXPECT_EQ(report["images"][0]["status"], "kept_coarse");
  EXPECT_EQ(report["images"][0]["reason"], "the map has no intensity");
}

TEST_F(RefineCommand, WithoutTheMapOrAnyImageNothingIsWritten) {
  RefineCommandOptions options = options_for("nothing");
  options.map = (world_ / "no_such_map.pcd").string();
  try {
    refine_command(options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no_such_map.pcd"));
  }
  EXPECT_FALSE(fs::exists(options.out));

  SparseModel model = read_sparse_model((world_ / "coarse").string());
  model.images = {model.images[1]};
  write_sparse_model_text((world_ / "one_bad").string(), model);
  options = options_for("nothing");
  options.poses = (world_ / "one_bad").string();
  EXPECT_THROW(refine_command(options), Error);
  EXPECT_FALSE(fs::exists(options.out));
}

TEST(RefineCommandOptions, WhatMustBeGivenIsNamed) {
  RefineCommandOptions options;
  options.map = "map.pcd";
  options.images = "images";
  options.poses = "model";
  try {
    options.validate();
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("out"));
  }
  options.out = "out";
  EXPECT_NO_THROW(options.validate());
  options.method = "icp";
  try {
    options.validate();
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cp_plus, lines, nid or none, got 'icp'"));
  }
  options.method = "nid";
  EXPECT_NO_THROW(options.validate());
  options.stages.refine.max_iterations = 0;
  EXPECT_THROW(options.validate(), Error);
}

}  // namespace
}  // namespace cpplus
