// `cpplus run` killed at random moments and started again until it ends has the outputs of a run that nobody killed.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "cpplus/core/random.h"
#include "cpplus/core/stopwatch.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// All steps on the simulated world, into one project folder below `directory`; the arguments that run them.
std::vector<std::string> write_run(const std::string& directory) {
  fs::create_directories(directory);
  const std::string rig = write_world_rig(directory + "/rig.yaml", inverse(world_lidar_from_camera()));
  const std::string project = directory + "/project";
  const auto section = [](const std::string& name, const std::map<std::string, std::string>& keys) {
    std::string text = name + ":\n";
    for (const auto& [key, value] : keys) text += fmt::format("  {}: {}\n", key, value);
    return text;
  };
  const std::string map = project + "/static_map.pcd";
  const std::string images = project + "/images";
  const std::string config = directory + "/run.yaml";
  write_file(config, section("import", {{"format", "colmap"},
                                        {"source", world_path("coarse_small")},
                                        {"images", world_path("images")},
                                        {"stamps", world_path("stamps.txt")},
                                        {"trajectory", world_path("scans/poses.txt")},
                                        {"rig", rig},
                                        {"copy", "true"},
                                        {"out", project}}) +
                         section("clean", {{"scans", world_path("scans")},
                                           {"poses", world_path("scans/poses.txt")},
                                           {"labels", project + "/labels"},
                                           {"out", map}}) +
                         section("poses", {{"trajectory", project + "/trajectory.txt"},
                                           {"rig", project + "/rig.yaml"},
                                           {"images", images},
                                           {"stamps", project + "/stamps.txt"},
                                           {"max_gap_s", "3"},
                                           {"out", project + "/placed"}}) +
                         section("refine", {{"map", map},
                                            {"images", images},
                                            {"poses", project + "/placed"},
                                            {"stamps", project + "/placed/stamps.txt"},
                                            {"out", project + "/refined"}}) +
                         section("colorize", {{"map", map},
                                              {"images", images},
                                              {"poses", project + "/refined/sparse"},
                                              {"out", project + "/coloured.ply"}}));
  return {"run", "--config", config};
}

/// What is in a file, but for the folder that the project is in and the times that a report states.
std::string content_of(const fs::path& file, const std::string& directory) {
  std::string text = read_file(file.string());
  if (file.filename() == "report.json") {
    auto report = nlohmann::json::parse(text);
    for (auto& image : report["images"]) image.erase("milliseconds");
    text = report.dump();
  }
  if (file.extension() == ".yaml" || file.extension() == ".json") {
    for (size_t at = 0; (at = text.find(directory)) != std::string::npos;) text.replace(at, directory.size(), "HERE");
  }
  return text;
}

/// Every file below the folder but the notes of what was done, whose times of change differ.
std::map<std::string, std::string> contents_below(const std::string& directory) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    const std::string name = fs::relative(entry.path(), directory).generic_string();
    if (entry.is_regular_file() && !name.starts_with("run.yaml.state")) {
      contents[name] = content_of(entry.path(), directory);
    }
  }
  return contents;
}

std::vector<std::string> names_of(const std::map<std::string, std::string>& contents) {
  std::vector<std::string> names;
  for (const auto& [name, content] : contents) names.push_back(name);
  return names;
}

/// "clean: done in 1.2 s" -> 1.2
double seconds_of(const std::string& step, const std::string& out) {
  const std::string begin = step + ": done in ";
  const size_t at = out.find(begin);
  return at == std::string::npos ? 0.0 : std::stod(out.substr(at + begin.size()));
}

/// Returns once a file is there and a little later, or after ten seconds, when the process may have ended.
void wait_for(const std::string& file, double then_s) {
  const Stopwatch watch;
  while (!file.empty() && !fs::exists(file) && watch.milliseconds() < 1e4) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(then_s));
}

TEST(Resume, ARunKilledAtRandomMomentsEndsAsOneThatWasNot) {
  const std::string directory = make_test_directory();
  const ProcessResult whole = run_cpplus(write_run(directory + "/whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;

  constexpr int kKilled = 128 + 9;
  const std::vector<std::string> arguments = write_run(directory + "/killed");
  Random random(7);
  int num_kills = 0;
  std::string before;  // what stands there when the step begins
  for (const std::string step : {"import", "clean", "poses", "refine", "colorize"}) {
    const double seconds = seconds_of(step, whole.out);
    for (int i = 0; i < 2; ++i) {
      const ProcessResult killed =
          run_cpplus_and_kill(arguments, [&] { wait_for(before, random.uniform(0.0, 0.1 + seconds)); });
      EXPECT_TRUE(killed.exit_code == kKilled || killed.exit_code == 0) << killed.err;
      num_kills += killed.exit_code == kKilled ? 1 : 0;
    }
    before = directory + "/killed/run.yaml.state/" + step + ".done";
  }
  const ProcessResult last = run_cpplus(arguments);
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_GE(num_kills, 5);
  RecordProperty("kills", num_kills);

  const auto expected = contents_below(directory + "/whole");
  const auto actual = contents_below(directory + "/killed");
  EXPECT_EQ(names_of(actual), names_of(expected)) << "nothing is missing and nothing half-written is left";
  for (const auto& [name, content] : expected) {
    EXPECT_TRUE(actual.count(name) > 0 && actual.at(name) == content) << name;
  }
  const ProcessResult again = run_cpplus(arguments);
  EXPECT_THAT(again.out, HasSubstr("import: up to date\nclean: up to date\nposes: up to date\nrefine: up to date\n"
                                   "colorize: up to date\n"));
}

TEST(Resume, AnImportIsDoneAgainWhenItsSourceChanged) {
  const std::string directory = make_test_directory();
  const std::string config = directory + "/run.yaml";
  const std::string project = directory + "/project";
  fs::create_directories(directory + "/model");
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    fs::copy_file(world_path(std::string("coarse_small/") + name), directory + "/model/" + name);
  }
  write_file(config, fmt::format("import: {{format: colmap, source: {}/model, images: {}, out: {}}}\n", directory,
                                 world_path("images"), project));
  const std::vector<std::string> arguments = {"run", "--config", config};
  ASSERT_EQ(run_cpplus(arguments).exit_code, 0);
  write_file(project + "/mine.txt", "by hand");
  write_file(project + "/project.yaml", read_file(project + "/project.yaml") + "# edited\n");
  EXPECT_THAT(run_cpplus(arguments).out, HasSubstr("import: up to date"));
  fs::copy_file(world_path("coarse_large/images.txt"), directory + "/model/images.txt",
                fs::copy_options::overwrite_existing);
  const ProcessResult again = run_cpplus(arguments);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("import: done"));
  EXPECT_EQ(read_file(project + "/mine.txt"), "by hand");
  EXPECT_EQ(read_file(project + "/project.yaml").find("edited"), std::string::npos);
}

}  // namespace
}  // namespace cpplus
