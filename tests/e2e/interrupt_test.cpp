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

// Returns once a file holds a text, or after a minute.
void wait_for(const std::string& text, const std::string& file) {
  const Stopwatch watch;
  while (watch.milliseconds() < 6e4 && read_file(file).find(text) == std::string::npos) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(Interrupt, RefineKeepsTheImagesThatItHasLookedAt) {
  const std::string out = make_test_directory() + "/refined";
  std::vector<std::string> arguments = refine_into(out);
  arguments.emplace_back("--json-progress");
  const ProcessResult result = run_cpplus_and_kill(
      arguments, [] { wait_for(R"("stage": "refine")", stderr_file()); }, SIGINT);
  ASSERT_EQ(result.exit_code, kInterrupted) << result.err;
  const auto report = nlohmann::json::parse(read_file(out + "/report.json"));
  EXPECT_EQ(report["images"].size(), 8u) << "every image has its row";
  EXPECT_THAT(result.err, HasSubstr(fmt::format("cpplus: interrupted: {} of 8 images", num_looked_at(report))));
  EXPECT_LT(num_looked_at(report), 8) << "the signal came at the first image";
  EXPECT_TRUE(fs::exists(out + "/sparse/images.txt"));
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

TEST(Interrupt, ViewStopsToServe) {
  const std::string result_folder = make_test_directory() + "/refined";
  run_well(refine_into(result_folder));
  const Stopwatch watch;
  const ProcessResult result = run_cpplus_and_kill(
      {"view", result_folder, "--port", "0"}, [] { wait_for("http://127.0.0.1:", stdout_file()); }, SIGTERM);
  EXPECT_EQ(result.exit_code, kInterrupted) << result.err;
  EXPECT_LT(watch.milliseconds(), 3e4);
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
