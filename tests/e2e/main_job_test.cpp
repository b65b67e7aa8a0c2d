// The main job through the program: a simulated world (made once by the test e2e/simulate), refined, coloured and
// evaluated.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using testing::ElementsAre;

std::string world(const std::string& name) { return std::string(CPPLUS_E2E_WORLD) + "/" + name; }

ProcessResult colorize(const std::string& poses, const std::string& out, const Arguments& more = {}) {
  Arguments arguments = {"colorize", "--map", world("map.pcd"), "--images", world("images"),
                         "--poses",  poses,   "--out",          out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_well(arguments);
}

/// Refines into a folder of its own below `directory` and returns that folder.
std::string refine(const std::string& poses, const std::string& directory, const Arguments& more = {}) {
  const std::string out = directory + "/refined";
  Arguments arguments = {"refine",  "--map", world("map.pcd"), "--images", world("images"),
                         "--poses", poses,   "--out",          out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  run_well(arguments);
  return out;
}

/// The images of report.json.
nlohmann::json read_images_report(const std::string& refined) {
  return nlohmann::json::parse(read_file(refined + "/report.json")).at("images");
}

nlohmann::json evaluate(const std::string& poses, const std::string& directory) {
  const std::string file = directory + "/evaluation.json";
  run_well({"evaluate", "--estimate", poses, "--reference", world("truth/on_map"), "--depth", world("truth/depth"),
            "--depth-poses", world("truth"), "--json", file});
  return nlohmann::json::parse(read_file(file));
}

std::set<std::string> files_below(const std::string& directory) {
  std::set<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) files.insert(fs::relative(entry.path(), directory).generic_string());
  }
  return files;
}

/// Median over the points that both clouds colour of the largest difference in a channel, grey levels.
int median_color_difference(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.size(), b.size());
  std::vector<int> differences;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a.num_views[i] == 0 || b.num_views[i] == 0) continue;
    int largest = 0;
    for (size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(int{a.colors[i][c]} - int{b.colors[i][c]}));
    differences.push_back(largest);
  }
  EXPECT_GT(differences.size(), a.size() / 2);
  std::nth_element(differences.begin(), differences.begin() + static_cast<long>(differences.size() / 2),
                   differences.end());
  return differences.at(differences.size() / 2);
}

TEST(MainJob, RefineLowersTheErrors) {
  const std::string directory = make_test_directory();
  const std::string refined = refine(world("coarse_medium"), directory);
  const nlohmann::json before = evaluate(world("coarse_medium"), directory);
  const nlohmann::json after = evaluate(refined + "/sparse", directory);
  const double median_before_px = before["summary"]["shift_px"]["median"];
  const double median_after_px = after["summary"]["shift_px"]["median"];
  EXPECT_LT(median_after_px, 0.4 * median_before_px);
  EXPECT_LT(median_after_px, 4.0);

  const nlohmann::json report = read_images_report(refined);
  ASSERT_EQ(report.size(), after["images"].size());
  size_t num_refined = 0;
  for (size_t i = 0; i < report.size(); ++i) {
    if (report[i]["status"] != "refined") continue;
    ++num_refined;
    ASSERT_EQ(report[i]["name"], after["images"][i]["name"]);
    const double shift_before_px = before["images"][i]["mean_shift_px"];
    const double shift_after_px = after["images"][i]["mean_shift_px"];
    EXPECT_LT(shift_after_px, shift_before_px + 1.0) << report[i]["name"] << " was accepted although it is worse";
  }
  EXPECT_GE(2 * num_refined, report.size());
}

TEST(MainJob, RefineKeepsEveryImageAndWritesNothingElse) {
  const std::string refined = refine(world("coarse_medium"), make_test_directory());
  EXPECT_THAT(files_below(refined),
              ElementsAre("report.json", "sparse/cameras.txt", "sparse/images.txt", "sparse/points3D.txt"));
  const SparseModel coarse = read_sparse_model(world("coarse_medium"));
  const SparseModel output = read_sparse_model(refined + "/sparse");
  const nlohmann::json report = read_images_report(refined);
  ASSERT_EQ(output.images.size(), coarse.images.size());
  ASSERT_EQ(report.size(), coarse.images.size());
  const std::set<std::string> known = {"refined", "kept_coarse", "blurred", "outside_map", "unreadable"};
  for (size_t i = 0; i < coarse.images.size(); ++i) {
    const std::string status = report[i]["status"];
    EXPECT_EQ(output.images[i].name, coarse.images[i].name);
    EXPECT_EQ(report[i]["name"], coarse.images[i].name);
    EXPECT_EQ(known.count(status), 1u) << status;
    EXPECT_EQ(report[i]["reason"] == "", status == "refined");
    const double moved_m =
        (camera_center(output.images[i].camera_from_map) - camera_center(coarse.images[i].camera_from_map)).norm();
    EXPECT_EQ(moved_m > 1e-9, status == "refined") << coarse.images[i].name << " " << status;
  }
}

TEST(MainJob, RefineTellsBlurredImages) {
  const std::string refined = refine(world("coarse_small"), make_test_directory());
  std::set<std::string> blurred;
  for (const auto& image : read_images_report(refined)) {
    if (image["status"] == "blurred") blurred.insert(image["name"]);
  }
  std::set<std::string> expected;
  for (const std::string& line : lines_of(read_file(world("truth/blurred.txt")))) {
    if (!line.starts_with("#")) expected.insert(line.substr(0, line.find(' ')));
  }
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(blurred, expected);
}

TEST(MainJob, RefineCanLeaveOutWhatItDidNotRefine) {
  const std::string refined = refine(world("coarse_small"), make_test_directory(), {"--only-refined"});
  std::set<std::string> expected;
  for (const auto& image : read_images_report(refined)) {
    if (image["status"] == "refined") expected.insert(image["name"]);
  }
  std::set<std::string> names;
  for (const PosedImage& image : read_sparse_model(refined + "/sparse").images) names.insert(image.name);
  EXPECT_EQ(names, expected);
  EXPECT_LT(names.size(), read_images_report(refined).size()) << "the world has a blurred image";
}

TEST(MainJob, RefineGivesTheSameBytesForEveryThreadCount) {
  const std::string directory = make_test_directory();
  const std::string one = refine(world("coarse_medium"), directory + "/one", {"--threads", "1"});
  const std::string two = refine(world("coarse_medium"), directory + "/two", {"--threads", "2"});
  for (const char* file : {"sparse/cameras.txt", "sparse/images.txt", "sparse/points3D.txt"}) {
    EXPECT_TRUE(read_file(one + "/" + file) == read_file(two + "/" + file)) << file;
  }
  nlohmann::json report_of_one = read_images_report(one);
  nlohmann::json report_of_two = read_images_report(two);
  for (nlohmann::json* report : {&report_of_one, &report_of_two}) {
    for (auto& image : *report) image.erase("milliseconds");
  }
  EXPECT_TRUE(report_of_one == report_of_two);
}

TEST(MainJob, RefineDrawsTheImagesItWorkedOn) {
  const std::string directory = make_test_directory();
  refine(world("coarse_small"), directory, {"--debug-images", directory + "/pictures"});
  size_t num_drawable = 0;
  for (const auto& image : read_images_report(directory + "/refined")) num_drawable += image["status"] != "blurred";
  EXPECT_EQ(files_below(directory + "/pictures").size(), num_drawable);
}

TEST(MainJob, ColorizeColoursWhatTheImagesSee) {
  const std::string directory = make_test_directory();
  colorize(world("truth/on_map"), directory + "/map.ply", {"--debug-images", directory + "/pictures"});
  const PointCloud input = read_point_cloud(world("map.pcd"));
  const PointCloud colored = read_point_cloud(directory + "/map.ply");
  EXPECT_EQ(colored.positions, input.positions);
  EXPECT_EQ(colored.intensities, input.intensities);
  const auto num_seen = std::count_if(colored.num_views.begin(), colored.num_views.end(), [](int n) { return n > 0; });
  EXPECT_GT(static_cast<double>(num_seen), 0.7 * static_cast<double>(colored.size()));
  const SparseModel model = read_sparse_model(world("truth/on_map"));
  EXPECT_EQ(files_below(directory).size(), 1 + model.images.size()) << "the map and a picture an image, nothing else";
}

TEST(MainJob, WrongPosesGiveWrongColours) {
  const std::string directory = make_test_directory();
  for (const char* poses : {"truth/on_map", "truth", "coarse_large"}) {
    colorize(world(poses), directory + "/" + fs::path(poses).filename().string() + ".ply");
  }
  const PointCloud right = read_point_cloud(directory + "/on_map.ply");
  const int of_truth = median_color_difference(right, read_point_cloud(directory + "/truth.ply"));
  const int of_coarse = median_color_difference(right, read_point_cloud(directory + "/coarse_large.ply"));
  EXPECT_LT(2 * of_truth, of_coarse);
}

TEST(MainJob, ColorizeGivesTheSameBytesForEveryFormatAndThreadCount) {
  const std::string directory = make_test_directory();
  for (const char* extension : {"ply", "pcd", "las"}) {
    const std::string one = fmt::format("{}/one.{}", directory, extension);
    const std::string two = fmt::format("{}/two.{}", directory, extension);
    colorize(world("coarse_small"), one, {"--threads", "1"});
    colorize(world("coarse_small"), two, {"--threads", "2"});
    EXPECT_TRUE(read_file(one) == read_file(two)) << extension;
  }
}

TEST(MainJob, ColorizeGivesTheSameInPartsOfTheMap) {
  const std::string directory = make_test_directory();
  const auto run = [&](const std::string& name, bool in_parts, const Arguments& more) {
    const std::string out = directory + "/" + name;
    // Smaller roots than usual: a part is at least four across.
    Arguments arguments = {
        "--hold-out", "4", "--report", out + ".json", "--debug-images", out, "--voxel-map.root-size-m", "0.5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = colorize(world("truth/on_map"), out + ".ply", arguments);
    EXPECT_EQ(result.out.find("parts of the map") != std::string::npos, in_parts) << result.out;
    std::string bytes = read_file(out + ".ply") + read_file(out + ".json");
    for (const std::string& file : files_below(out)) bytes += read_file(out + "/" + file);
    return bytes;
  };
  const std::string whole = run("whole", false, {});
  EXPECT_TRUE(run("parts", true, {"--max-part-points", "100000", "--threads", "1"}) == whole);
  EXPECT_TRUE(run("more_parts", true, {"--max-part-points", "5000", "--threads", "2"}) == whole);
}

TEST(MainJob, EvaluateIsZeroForTheReferenceAndGrowsWithTheError) {
  const std::string directory = make_test_directory();
  EXPECT_EQ(evaluate(world("truth/on_map"), directory)["summary"]["shift_px"]["max"], 0.0);
  double last = 0.0;
  for (const char* level : {"truth", "coarse_small", "coarse_medium"}) {
    const double shift = evaluate(world(level), directory)["summary"]["shift_px"]["median"];
    EXPECT_GT(shift, last) << level;
    last = shift;
  }
}

}  // namespace
}  // namespace cpplus
