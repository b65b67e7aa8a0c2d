// Dynamic objects through the program: a simulated world with people in it, cleaned and compared with its labels.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "cpplus/io/point_cloud_io.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

void clean(const std::string& world, const std::string& out, const std::string& threads) {
  run_well({"clean", "--scans", world + "/scans", "--poses", world + "/scans/poses.txt", "--out", out + "/map.pcd",
            "--labels", out, "--threads", threads});
}

TEST(Clean, RemovesThePeopleOfASimulatedWorld) {
  const std::string directory = make_test_directory();
  const std::string world = directory + "/world";
  run_well({"simulate", "--scene", "hall", "--seed", "4", "--images", "1", "--blurred", "0", "--width", "32",
            "--height", "24", "--scans", "24", "--lidar.azimuth-steps", "900", "--out", world});
  clean(world, directory + "/one", "1");
  clean(world, directory + "/two", "2");

  std::array<double, 2> all{};
  std::array<double, 2> right{};
  size_t num_scans = 0;
  size_t num_static = 0;
  for (const auto& entry : fs::directory_iterator(world + "/scans")) {
    if (entry.path().extension() != ".label") continue;
    ++num_scans;
    const std::string name = entry.path().filename().string();
    const std::string truth = read_file(entry.path().string());
    const std::string labels = read_file(directory + "/one/" + name);
    EXPECT_EQ(labels, read_file(directory + "/two/" + name)) << "depends on the number of threads";
    ASSERT_EQ(labels.size(), truth.size());
    for (size_t i = 0; i < truth.size(); ++i) {
      const auto label = static_cast<size_t>(truth[i]);
      all.at(label) += 1.0;
      right.at(label) += labels[i] == truth[i] ? 1.0 : 0.0;
      num_static += labels[i] == 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(num_scans, 24u);
  EXPECT_GE(right[0] / all[0], 0.96) << "static points kept";
  EXPECT_GE(right[1] / all[1], 0.94) << "dynamic points removed";
  EXPECT_EQ(read_point_cloud(directory + "/one/map.pcd").size(), num_static);
  EXPECT_EQ(read_file(directory + "/one/map.pcd"), read_file(directory + "/two/map.pcd"));
}

}  // namespace
}  // namespace cpplus
