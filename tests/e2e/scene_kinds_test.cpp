// The main job on kinds of scenes and cameras that differ from the world of main_job_test: each test simulates its own.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <set>

#include "run_cpplus.h"

namespace cpplus {
namespace {

using Arguments = std::vector<std::string>;

std::string simulate(const std::string& directory, const Arguments& more) {
  const std::string world = directory + "/world";
  Arguments arguments = {"simulate", "--out", world, "--width", "640", "--height", "480"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  run_well(arguments);
  return world;
}

/// Refines the poses of a world's folder and returns the images of report.json.
nlohmann::json refine(const std::string& world, const std::string& level, const std::string& out) {
  run_well({"refine", "--map", world + "/map.pcd", "--images", world + "/images", "--poses", world + "/" + level,
            "--stamps", world + "/stamps.txt", "--out", out});
  return nlohmann::json::parse(read_file(out + "/report.json")).at("images");
}

nlohmann::json evaluate(const std::string& world, const std::string& poses) {
  const std::string file = world + "/evaluation.json";
  run_well({"evaluate", "--estimate", poses, "--reference", world + "/truth/on_map", "--depth", world + "/truth/depth",
            "--depth-poses", world + "/truth", "--json", file});
  return nlohmann::json::parse(read_file(file));
}

std::set<std::string> with_status(const nlohmann::json& images, const std::string& status) {
  std::set<std::string> names;
  for (const auto& image : images) {
    if (image["status"] == status) names.insert(image["name"]);
  }
  return names;
}

std::set<std::string> truly_blurred(const std::string& world) {
  std::set<std::string> names;
  for (const std::string& line : lines_of(read_file(world + "/truth/blurred.txt"))) {
    if (!line.empty() && !line.starts_with("#")) names.insert(line.substr(0, line.find(' ')));
  }
  return names;
}

TEST(SceneKinds, FisheyeOf180DegreesIsRefined) {
  const std::string directory = make_test_directory();
  const std::string world =
      simulate(directory, {"--scene", "room", "--seed", "4", "--camera", "OPENCV_FISHEYE", "--images", "5"});
  const nlohmann::json report = refine(world, "coarse_medium", directory + "/refined");
  EXPECT_EQ(with_status(report, "blurred"), truly_blurred(world));
  const nlohmann::json before = evaluate(world, world + "/coarse_medium");
  const nlohmann::json after = evaluate(world, directory + "/refined/sparse");
  EXPECT_LT(after["summary"]["shift_px"]["median"], 2.5);
  const std::set<std::string> refined = with_status(report, "refined");
  EXPECT_GE(refined.size(), 3u);
  for (size_t i = 0; i < after["images"].size(); ++i) {
    const std::string name = after["images"][i]["name"];
    if (refined.count(name) == 0) continue;
    EXPECT_LT(after["images"][i]["mean_shift_px"], before["images"][i]["mean_shift_px"]) << name;
  }
}

TEST(SceneKinds, SharpImagesOfABareCorridorAreNotCalledBlurred) {
  const std::string directory = make_test_directory();
  const std::string world =
      simulate(directory, {"--scene", "corridor", "--seed", "3", "--images", "6", "--blurred", "2", "--scans", "12"});
  const nlohmann::json report = refine(world, "coarse_small", directory + "/refined");
  EXPECT_EQ(with_status(report, "blurred"), truly_blurred(world));
  EXPECT_EQ(truly_blurred(world).size(), 2u);
}

}  // namespace
}  // namespace cpplus
