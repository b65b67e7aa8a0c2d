// `cpplus index`, and commands on what it writes: the same results as on the point cloud itself.
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "cpplus/core/random.h"
#include "cpplus/core/stopwatch.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using testing::HasSubstr;

std::string indexed_world(const std::string& directory) {
  const std::string map = directory + "/map.vox";
  run_well({"index", world_path("map.pcd"), "--out", map});
  return map;
}

/// Refines with this map and returns the folder.
std::string refine(const std::string& map, const std::string& out) {
  run_well({"refine", "--map", map, "--images", world_path("images"), "--poses", world_path("coarse_small"), "--stamps",
            world_path("stamps.txt"), "--out", out});
  return out;
}

/// The report without the names of map and folder, and without times.
nlohmann::json report_of(const std::string& folder) {
  auto report = nlohmann::json::parse(read_file(folder + "/report.json"));
  for (auto& image : report["images"]) image.erase("milliseconds");
  report["map"].erase("path");
  report.erase("inputs");
  report["options"].erase("map");
  report["options"].erase("out");
  return report;
}

TEST(Index, RefineFindsTheSameOnItAsOnThePointCloud) {
  const std::string directory = make_test_directory();
  const std::string of_cloud = refine(world_path("map.pcd"), directory + "/cloud");
  const std::string of_index = refine(indexed_world(directory), directory + "/index");
  EXPECT_EQ(read_file(of_index + "/sparse/images.txt"), read_file(of_cloud + "/sparse/images.txt"));
  const nlohmann::json report = report_of(of_index);
  EXPECT_EQ(report, report_of(of_cloud));
  EXPECT_EQ(report["images"].size(), 8u);
  EXPECT_GT(report["map"]["edges"], 0) << report["map"];
}

TEST(Index, OtherCommandsWriteTheSameFiles) {
  const std::string directory = make_test_directory();
  const std::string index = indexed_world(directory);
  const Arguments scene = {"--images", world_path("images"), "--poses", world_path("truth/on_map")};
  for (const auto& [name, map] : {std::pair("cloud", world_path("map.pcd")), {"index", index}}) {
    const std::string out = directory + "/" + name;
    const auto run = [&](Arguments arguments) {
      arguments.insert(arguments.end(), {"--map", map});
      run_well(arguments);
    };
    run({"colorize", scene[0], scene[1], scene[2], scene[3], "--out", out + "/coloured.ply"});
    run({"export", "--format", "colmap-text", scene[0], scene[1], scene[2], scene[3], "--out", out + "/colmap"});
    run({"evaluate", "--estimate", world_path("coarse_small"), "--reference", world_path("truth/on_map"), "--json",
         out + "/evaluation.json"});
  }
  for (const char* file : {"coloured.ply", "colmap/points3D.txt", "colmap/images.txt", "evaluation.json"}) {
    const std::string expected = read_file(directory + "/cloud/" + file);
    EXPECT_GT(expected.size(), 200u) << file;
    EXPECT_TRUE(read_file(directory + "/index/" + file) == expected) << file;
  }
}

TEST(Index, InfoVerifiesAndDescribes) {
  const std::string index = indexed_world(make_test_directory());
  const std::string out = run_well({"info", index}).out;
  EXPECT_THAT(out, HasSubstr(index + ": voxel map, "));
  EXPECT_THAT(out, HasSubstr("checksums are right"));
  const std::string of_cloud = run_well({"info", world_path("map.pcd")}).out;
  for (const std::string& line : lines_of(of_cloud)) {
    if (!line.starts_with(" ")) continue;
    EXPECT_THAT(out, HasSubstr(line)) << "extent and attributes are the same";
  }
}

TEST(Index, KilledAtRandomMomentsItLeavesNothingThatIsTakenForWhole) {
  const std::string directory = make_test_directory();
  Arguments arguments = {"index", "--memory-mb", "64"};
  arguments.insert(arguments.end(), 20, world_path("map.pcd"));
  const auto index_to = [&](const std::string& out) {
    Arguments all = arguments;
    all.insert(all.end(), {"--out", out});
    return all;
  };
  const std::string whole = directory + "/whole/map.vox";
  const Stopwatch watch;
  run_well(index_to(whole));
  const double seconds = 1e-3 * watch.milliseconds();
  const std::string expected = read_file(whole);

  constexpr int kKilled = 128 + 9;
  const std::string killed = directory + "/killed/map.vox";
  Random random(11);
  int num_kills = 0;
  for (int i = 0; i < 6; ++i) {
    const ProcessResult result = run_cpplus_and_kill(index_to(killed), [&] {
      std::this_thread::sleep_for(std::chrono::duration<double>(random.uniform(0.0, seconds)));
    });
    EXPECT_TRUE(result.exit_code == kKilled || result.exit_code == 0) << result.err;
    num_kills += result.exit_code == kKilled ? 1 : 0;
    if (!fs::exists(killed)) continue;
    EXPECT_TRUE(read_file(killed) == expected) << "what stands in the file's place is whole";
    fs::remove(killed);
  }
  EXPECT_GE(num_kills, 2);
  run_well(index_to(killed));
  EXPECT_TRUE(read_file(killed) == expected);
  EXPECT_EQ(std::distance(fs::directory_iterator(directory + "/killed"), {}), 1) << "temporaries are left";
}

}  // namespace
}  // namespace cpplus
