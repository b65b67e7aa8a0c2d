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

/// Runs the program and expects it to succeed without a word on stderr.
void run_well(const Arguments& arguments) {
  const ProcessResult result = run_cpplus(arguments);
  EXPECT_EQ(result.exit_code, 0) << testing::PrintToString(arguments);
  EXPECT_EQ(result.err, "") << testing::PrintToString(arguments);
}

void colorize(const std::string& poses, const std::string& out, const Arguments& more = {}) {
  Arguments arguments = {"colorize", "--map", world("map.pcd"), "--images", world("images"),
                         "--poses",  poses,   "--out",          out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  run_well(arguments);
}

nlohmann::json evaluate(const std::string& poses) {
  const std::string file = make_test_directory() + "_evaluation.json";
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

TEST(MainJob, EvaluateIsZeroForTheReferenceAndGrowsWithTheError) {
  EXPECT_EQ(evaluate(world("truth/on_map"))["summary"]["shift_px"]["max"], 0.0);
  double last = 0.0;
  for (const char* level : {"truth", "coarse_small", "coarse_medium"}) {
    const double shift = evaluate(world(level))["summary"]["shift_px"]["median"];
    EXPECT_GT(shift, last) << level;
    last = shift;
  }
}

}  // namespace
}  // namespace cpplus
