// Stamps that are wrong by 20 ms, and a rolling shutter of 30 ms, found by the joint solve.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

constexpr double kOffsetS = 0.02;
constexpr double kReadoutS = 0.06;  // a slow one: at 30 ms the poses of the middle rows suffer little

/// A hall with poses of the LiDAR at 10 Hz, as an odometry gives them.
std::string simulate_hall(const std::string& world, double readout_s) {
  const ProcessResult result = run_cpplus({"simulate",
                                           "--scene",
                                           "hall",
                                           "--seed",
                                           "1",
                                           "--width",
                                           "512",
                                           "--height",
                                           "384",
                                           "--images",
                                           "16",
                                           "--scans",
                                           "300",
                                           "--lidar.rings",
                                           "16",
                                           "--lidar.azimuth-steps",
                                           "250",
                                           "--render.readout-s",
                                           fmt::format("{}", readout_s),
                                           "--out",
                                           world});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return world;
}

std::string write_late_stamps(const std::string& world, const std::string& file) {
  std::ifstream stamps(world + "/stamps.txt");
  std::string name;
  std::string late;
  double stamp_s = 0.0;
  while (stamps >> name >> stamp_s) late += fmt::format("{} {:.6f}\n", name, stamp_s + kOffsetS);
  write_file(file, late);
  return file;
}

/// The coarse poses have the true extrinsic and a trajectory that is as good as the map, so nothing is wrong but time.
TEST(TimeOffset, OfTwentyMillisecondsIsFoundToTwo) {
  const std::string directory = make_test_directory();
  const std::string world = simulate_hall(directory + "/world", 0.0);
  const std::string rig = write_world_rig(directory + "/rig.yaml", inverse(world_lidar_from_camera(world)), world);
  const std::string trajectory = world + "/scans/poses.txt";
  const std::string coarse = directory + "/coarse";
  const ProcessResult posed =
      run_cpplus({"poses", "--trajectory", trajectory, "--rig", rig, "--images", world + "/images", "--stamps",
                  write_late_stamps(world, directory + "/late.txt"), "--out", coarse});
  ASSERT_EQ(posed.exit_code, 0) << posed.err;
  const ProcessResult refined =
      run_cpplus({"refine", "--map", world + "/map.pcd", "--images", world + "/images", "--poses", coarse, "--stamps",
                  coarse + "/stamps.txt", "--trajectory", trajectory, "--out", directory + "/refined"});
  ASSERT_EQ(refined.exit_code, 0) << refined.err;
  const nlohmann::json shared = nlohmann::json::parse(read_file(directory + "/refined/report.json")).at("shared");
  ASSERT_EQ(shared.size(), 1u);
  const nlohmann::json& camera = *shared.begin();
  EXPECT_NEAR(camera.at("time_offset_s").get<double>(), -kOffsetS, 0.002) << "to be added to the late stamps";
  EXPECT_LT(camera.at("time_offset_sigma_s").get<double>(), 0.004);
  EXPECT_GT(camera.at("time_offset_sigma_s").get<double>(), 0.0002);
  EXPECT_NEAR(camera.at("readout_s").get<double>(), 0.0, 0.005) << "a global shutter";
  EXPECT_EQ(camera.at("undetermined").size(), 0u);
}

TEST(RollingShutter, TheReadoutTimeIsFoundFromCoarsePoses) {
  const std::string directory = make_test_directory();
  const std::string world = simulate_hall(directory + "/world", kReadoutS);
  const auto refine = [&](const std::string& out, const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"refine",
                                          "--map",
                                          world + "/map.pcd",
                                          "--images",
                                          world + "/images",
                                          "--poses",
                                          world + "/coarse_small",
                                          "--stamps",
                                          world + "/stamps.txt",
                                          "--trajectory",
                                          world + "/scans/poses.txt",
                                          "--out",
                                          out};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProcessResult refined = run_cpplus(arguments);
    EXPECT_EQ(refined.exit_code, 0) << refined.err;
    const ProcessResult evaluated =
        run_cpplus({"evaluate", "--estimate", out + "/sparse", "--reference", world + "/truth", "--map",
                    world + "/map.pcd", "--json", out + "/evaluation.json"});
    EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
    return nlohmann::json::parse(read_file(out + "/evaluation.json"));
  };
  const nlohmann::json rolling = refine(directory + "/rolling", {});
  const nlohmann::json global = refine(directory + "/global", {"--joint-solve.imaging.readout-sigma-s", "0"});
  const nlohmann::json report = nlohmann::json::parse(read_file(directory + "/rolling/report.json"));
  EXPECT_NEAR(report.at("shared").begin()->at("readout_s").get<double>(), kReadoutS, 0.005);
  // An image that keeps its coarse pose (a blurred one) tells nothing of the shutter: the middle image, not the mean.
  const auto median_shift = [](const nlohmann::json& evaluation) {
    std::vector<double> shifts;
    for (const auto& image : evaluation.at("images")) shifts.push_back(image.at("mean_shift_px").get<double>());
    std::sort(shifts.begin(), shifts.end());
    return shifts.at(shifts.size() / 2);
  };
  EXPECT_LT(median_shift(rolling), 0.8 * median_shift(global));
}

}  // namespace
}  // namespace cpplus
