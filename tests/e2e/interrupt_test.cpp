// Ctrl-C: the program stops, says so, and keeps what is done.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "cpplus/core/stopwatch.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int kInterrupted = 130;

std::vector<std::string> refine_into(const std::string& out) {
  return {"refine",
          "--map",
          world_path("map.pcd"),
          "--images",
          world_path("images"),
          "--poses",
          world_path("coarse_small"),
          "--stamps",
          world_path("stamps.txt"),
          "--threads",
          "1",
          "--out",
          out};
}

// Images that an interrupted run looked at.
int num_looked_at(const nlohmann::json& report) {
  int count = 0;
  for (const auto& image : report["images"]) count += image["reason"] != "interrupted before it was looked at";
  return count;
}

TEST(Interrupt, RefineKeepsTheImagesThatItHasLookedAt) {
  const std::string directory = make_test_directory();
  const Stopwatch watch;
  const ProcessResult whole = run_cpplus(refine_into(directory + "/whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const double seconds = 1e-3 * watch.milliseconds();

  // Where in its work a signal finds the program is up to the machine: from early to late, until images were reached.
  bool kept_some = false;
  for (int tenth = 2; tenth < 10 && !kept_some; ++tenth) {
    const std::string out = fmt::format("{}/{}", directory, tenth);
    const ProcessResult result = run_cpplus_and_kill(
        refine_into(out), [&] { std::this_thread::sleep_for(std::chrono::duration<double>(0.1 * tenth * seconds)); },
        SIGINT);
    if (result.exit_code == 0) continue;  // it was faster than the first time
    ASSERT_EQ(result.exit_code, kInterrupted) << result.err;
    EXPECT_THAT(result.err, StartsWith("cpplus: interrupted"));
    if (!fs::exists(out)) continue;  // before the first image
    const auto report = nlohmann::json::parse(read_file(out + "/report.json"));
    EXPECT_EQ(report["images"].size(), 8u) << "every image has its row";
    const int looked_at = num_looked_at(report);
    EXPECT_THAT(result.err, HasSubstr(fmt::format("{} of 8 images", looked_at)));
    EXPECT_TRUE(fs::exists(out + "/sparse/images.txt"));
    kept_some = looked_at > 0;
  }
  EXPECT_TRUE(kept_some);
}

TEST(Interrupt, ColorizeLeavesNothingHalfWritten) {
  const std::string directory = make_test_directory();
  const ProcessResult result = run_cpplus_and_kill(
      {"colorize", "--map", world_path("map.pcd"), "--images", world_path("images"), "--poses",
       world_path("coarse_small"), "--out", directory + "/coloured.ply"},
      [] { std::this_thread::sleep_for(std::chrono::milliseconds(60)); }, SIGINT);
  if (result.exit_code == 0) GTEST_SKIP() << "colorize was faster than the signal";
  EXPECT_EQ(result.exit_code, kInterrupted) << result.err;
  EXPECT_TRUE(fs::is_empty(directory));
}

TEST(JsonProgress, EveryLineIsAnObjectAndEveryStageEnds) {
  const std::string directory = make_test_directory();
  std::vector<std::string> arguments = refine_into(directory + "/out");
  arguments.emplace_back("--json-progress");
  const ProcessResult result = run_cpplus(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::map<std::string, nlohmann::json> last;
  for (const std::string& line : lines_of(result.err)) {
    const auto progress = nlohmann::json::parse(line);
    last[progress["stage"]] = progress;
  }
  ASSERT_TRUE(last.contains("refine"));
  for (const auto& [stage, progress] : last) EXPECT_EQ(progress["done"], progress["total"]) << stage;
  EXPECT_EQ(last["refine"]["total"], 8);
  EXPECT_GT(last["refine"]["per_second"], 0.0);
}

}  // namespace
}  // namespace cpplus
