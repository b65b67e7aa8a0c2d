// `cpplus view --export`: the same files for any number of threads, and of a voxel map file as of its point cloud.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

/// Names of the files in a folder and below it, in order, without the one that says what the tiles were made of.
std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) names.push_back(fs::relative(entry.path(), folder).string());
  }
  std::erase(names, "tiles/made_of.txt");
  std::sort(names.begin(), names.end());
  return names;
}

void expect_same_files(const std::string& folder, const std::string& other) {
  const std::vector<std::string> names = files_in(folder);
  EXPECT_THAT(names, testing::IsSupersetOf({"index.html", "tileset.json", "tiles/000000.pnts", "photos/000000.jpg"}));
  ASSERT_EQ(names, files_in(other));
  for (const std::string& name : names) {
    EXPECT_EQ(read_file(folder + "/" + name), read_file(other + "/" + name)) << name;
  }
}

class ViewExport : public testing::Test {
 protected:
  void SetUp() override {
    run_well({"refine", "--map", world_path("map.pcd"), "--images", world_path("images"), "--poses",
              world_path("coarse_small"), "--no-joint", "--out", result()});
    run_well({"colorize", "--map", world_path("map.pcd"), "--images", world_path("images"), "--poses",
              result() + "/sparse", "--out", path("colours.ply")});
  }

  std::string path(const std::string& name) const { return directory_ + "/" + name; }
  std::string result() const { return path("result"); }

  std::string exported(const std::string& name, const Arguments& more) const {
    Arguments arguments = {"view", result(), "--export", path(name)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    run_well(arguments);
    return path(name);
  }

 private:
  std::string directory_ = make_test_directory();
};

TEST_F(ViewExport, IsTheSameForAnyNumberOfThreads) {
  const Arguments cloud = {"--cloud", path("colours.ply"), "--threads"};
  const auto with = [&](const std::string& threads) {
    Arguments arguments = cloud;
    arguments.push_back(threads);
    return exported("threads_" + threads, arguments);
  };
  const std::string one = with("1");
  expect_same_files(one, with("2"));
  expect_same_files(one, with("5"));
}

TEST_F(ViewExport, ShowsAVoxelMapFileAsItsPointCloud) {
  run_well({"index", path("colours.ply"), "--out", path("coloured.vox")});
  const std::string of_cloud = exported("of_cloud", {"--cloud", path("colours.ply")});
  // Beside the result, so that it need not be named.
  expect_same_files(of_cloud, exported("of_index", {}));
  const std::string of_map = exported("of_map", {"--cloud", world_path("map.pcd")});
  EXPECT_NE(read_file(of_map + "/tiles/000000.pnts"), read_file(of_cloud + "/tiles/000000.pnts")) << "no colours";
}

}  // namespace
}  // namespace cpplus
