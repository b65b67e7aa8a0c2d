// A city district that is written while it is recorded: as good a world as the others.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "cpplus/core/stopwatch.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using testing::HasSubstr;
using testing::IsEmpty;

Arguments district(const std::string& out, const Arguments& more) {
  Arguments arguments = {"simulate", "--scene", "district", "--area", "0.01", "--out", out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// One that takes seconds.
Arguments tiny_district(const std::string& out, const Arguments& more = {}) {
  Arguments arguments = district(out, {"--points", "0.2", "--images", "2", "--width", "128", "--height", "96",
                                       "--lidar.azimuth-steps", "360", "--render.samples-per-pixel", "1"});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::map<std::string, std::string> files_below(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_file(entry.path().string());
  }
  return files;
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

double median_shift_px(const std::string& world, const std::string& poses) {
  const std::string file = world + "/evaluation.json";
  run_well({"evaluate", "--estimate", poses, "--reference", world + "/truth/on_map", "--depth", world + "/truth/depth",
            "--depth-poses", world + "/truth", "--json", file});
  return nlohmann::json::parse(read_file(file)).at("summary").at("shift_px").at("median");
}

TEST(DistrictWorld, ItsPosesAreRefined) {
  const std::string world = make_test_directory() + "/world";
  run_well(district(world, {"--points", "3", "--images", "6", "--width", "640", "--height", "480", "--blurred", "0"}));
  EXPECT_THAT(run_well({"info", world}).out, HasSubstr("nothing is missing to refine it"));
  run_well({"refine", "--map", world + "/map.pcd", "--images", world + "/images", "--poses", world + "/coarse_medium",
            "--stamps", world + "/stamps.txt", "--out", world + "/refined"});
  EXPECT_LT(median_shift_px(world, world + "/refined/sparse"), 0.35 * median_shift_px(world, world + "/coarse_medium"));
}

TEST(DistrictWorld, TheSameFilesForAnyNumberOfThreadsAndOverAnEarlierWorld) {
  const std::string directory = make_test_directory();
  run_well(tiny_district(directory + "/one", {"--threads", "1"}));
  run_well(tiny_district(directory + "/two", {"--threads", "2", "--seed", "9"}));
  write_file(directory + "/two/notes.txt", "mine");
  write_file(directory + "/two/images/000007.jpg", "of an earlier world");
  run_well(tiny_district(directory + "/two", {"--threads", "2"}));
  std::map<std::string, std::string> files = files_below(directory + "/two");
  EXPECT_EQ(files["notes.txt"], "mine");
  files.erase("notes.txt");
  EXPECT_TRUE(files == files_below(directory + "/one"));
  EXPECT_TRUE(files.contains("map.pcd"));
  EXPECT_THAT(names_in(directory), testing::UnorderedElementsAre("one", "two"));
}

TEST(DistrictWorld, AnInterruptedOneLeavesNothing) {
  const std::string directory = make_test_directory();
  const auto after_some_images = [&]() {
    const Stopwatch watch;
    while (watch.milliseconds() < 6e4 && read_file(stderr_file()).find(R"("stage": "record")") == std::string::npos) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  const Arguments arguments = tiny_district(directory + "/world", {"--json-progress"});
  EXPECT_EQ(run_cpplus_and_kill(arguments, after_some_images, SIGINT).exit_code, 130);
  EXPECT_THAT(names_in(directory), IsEmpty());
  // What a killed one leaves goes with the next.
  EXPECT_EQ(run_cpplus_and_kill(arguments, after_some_images).exit_code, 128 + SIGKILL);
  EXPECT_FALSE(fs::exists(directory + "/world"));
  run_well(tiny_district(directory + "/world"));
  EXPECT_THAT(names_in(directory), testing::ElementsAre("world"));
}

}  // namespace
}  // namespace cpplus
