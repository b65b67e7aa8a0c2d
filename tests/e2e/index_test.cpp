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

/// Many times the world's map, in little memory, to `out`: sorting it takes a while, and so does building.
Arguments index_many_to(const std::string& out, size_t times, const Arguments& more = {}) {
  Arguments arguments = {"index", "--memory-mb", "64", "--out", out};
  arguments.insert(arguments.end(), times, world_path("map.pcd"));
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// Runs it and kills it once it has sorted all points.
void kill_when_sorted(const Arguments& arguments, const std::string& out) {
  const fs::path path(out);
  const fs::path plan = path.parent_path() / ("." + path.filename().string() + ".sorted") / "plan";
  const ProcessResult result = run_cpplus_and_kill(arguments, [&] {
    const Stopwatch watch;
    while (!fs::exists(plan) && watch.milliseconds() < 6e4) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  ASSERT_EQ(result.exit_code, 128 + 9) << result.err;
  ASSERT_FALSE(fs::exists(out));
}

size_t num_files_in(const std::string& directory) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(directory), {}));
}

constexpr const char* kWentOn = "went on from the points that a run before had sorted";

TEST(Index, KilledAfterSortingTheNextRunGoesOnFromThere) {
  const std::string directory = make_test_directory();
  const std::string whole = directory + "/whole/map.vox";
  const std::string killed = directory + "/killed/map.vox";
  EXPECT_THAT(run_well(index_many_to(whole, 20)).out, Not(HasSubstr(kWentOn)));
  kill_when_sorted(index_many_to(killed, 20), killed);
  kill_when_sorted(index_many_to(killed, 20), killed);
  EXPECT_THAT(run_well(index_many_to(killed, 20)).out, HasSubstr(kWentOn));
  EXPECT_TRUE(read_file(killed) == read_file(whole));
  EXPECT_EQ(num_files_in(directory + "/killed"), 1u) << "temporaries are left";
}

TEST(Index, SortedPointsOfOtherInputsOrOptionsAreThrownAway) {
  const std::string directory = make_test_directory();
  const std::string out = directory + "/out/map.vox";
  const std::string input = directory + "/more.pcd";
  fs::copy_file(world_path("map.pcd"), input);
  const auto index_to = [&](const std::string& file, const Arguments& more) {
    Arguments all = more;
    all.push_back(input);
    return index_many_to(file, 20, all);
  };
  const auto expect_anew = [&](const Arguments& more, const std::string& what) {
    EXPECT_THAT(run_well(index_to(out, more)).out, Not(HasSubstr(kWentOn))) << what;
    run_well(index_to(directory + "/expected/map.vox", more));
    EXPECT_TRUE(read_file(out) == read_file(directory + "/expected/map.vox")) << what;
    EXPECT_EQ(num_files_in(directory + "/out"), 1u) << what;
    fs::remove(out);
  };
  kill_when_sorted(index_to(out, {}), out);
  expect_anew({"--voxel-map.leaf-size-m", "0.125"}, "other voxels");
  kill_when_sorted(index_to(out, {}), out);
  fs::last_write_time(input, fs::last_write_time(input) + std::chrono::seconds(3));
  expect_anew({}, "an input was written again");
  kill_when_sorted(index_to(out, {}), out);
  fs::resize_file(directory + "/out/.map.vox.sorted/points", 1000);
  expect_anew({}, "the sorted points are cut off");
}

TEST(Index, KilledAtRandomMomentsItLeavesNothingThatIsTakenForWhole) {
  const std::string directory = make_test_directory();
  const auto index_to = [](const std::string& out) { return index_many_to(out, 20); };
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
  EXPECT_EQ(num_files_in(directory + "/killed"), 1u) << "temporaries are left";
}

}  // namespace
}  // namespace cpplus
