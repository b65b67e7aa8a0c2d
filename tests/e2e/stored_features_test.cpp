// Planes and edges of a map are found once: `cpplus refine` on a voxel map keeps them beside it, tile by tile.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "cpplus/core/random.h"
#include "cpplus/core/stopwatch.h"
#include "cpplus/io/colmap_io.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using testing::HasSubstr;

/// The world's map as a voxel map, and what refine needs to work on it in several tiles.
class StoredFeatures : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = make_test_directory();
    map_ = directory_ + "/map.vox";
    run_well(index());
  }

  /// Of small roots: tiles are four of them across at least, and the world is a few rooms.
  Arguments index() const { return {"index", world_path("map.pcd"), "--out", map_, "--voxel-map.root-size-m", "1"}; }

  Arguments refine(const std::string& name, const Arguments& more = {}) const {
    Arguments arguments = {"refine",
                           "--map",
                           map_,
                           "--images",
                           world_path("images"),
                           "--poses",
                           world_path("coarse_small"),
                           "--stamps",
                           world_path("stamps.txt"),
                           "--out",
                           directory_ + "/" + name,
                           "--tiles.max-points",
                           kMaxPoints};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  std::string poses_of(const std::string& name) const {
    return read_file(directory_ + "/" + name + "/sparse/images.txt");
  }

  std::vector<std::string> tile_files() const {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(map_ + ".features")) files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    return files;
  }

  static constexpr const char* kMaxPoints = "30000";
  std::string directory_;
  std::string map_;
};

TEST_F(StoredFeatures, ASecondRunReadsThemAndFindsTheSamePoses) {
  EXPECT_THAT(run_well(refine("first")).out, HasSubstr("those of 0 were there"));
  const std::vector<std::string> files = tile_files();
  ASSERT_GE(files.size(), 2u);
  std::vector<std::string> contents;
  for (const std::string& file : files) contents.push_back(read_file(file));
  EXPECT_THAT(run_well(refine("second")).out, HasSubstr(" of 0 tiles were found"));
  EXPECT_EQ(poses_of("second"), poses_of("first"));

  fs::remove_all(map_ + ".features");
  run_well(refine("one_thread", {"--threads", "1"}));
  EXPECT_EQ(poses_of("one_thread"), poses_of("first"));
  ASSERT_EQ(tile_files(), files);
  for (size_t i = 0; i < files.size(); ++i) EXPECT_TRUE(read_file(files[i]) == contents[i]) << files[i];
}

TEST_F(StoredFeatures, ReportTakesThoseOfRefine) {
  run_well(refine("refined"));
  const std::vector<std::string> files = tile_files();
  fs::remove_all(map_ + ".features");
  run_well({"report", directory_ + "/refined"});
  EXPECT_EQ(tile_files(), files) << "found again with the options of refine";
}

TEST_F(StoredFeatures, IndexFindsThemBeforehand) {
  run_well(refine("first"));
  Arguments with_features = index();
  with_features.insert(with_features.end(), {"--features", "--tiles.max-points", kMaxPoints});
  run_well(with_features);
  EXPECT_THAT(run_well(refine("second")).out, HasSubstr(" of 0 tiles were found"));
  EXPECT_EQ(poses_of("second"), poses_of("first"));
}

TEST_F(StoredFeatures, PosesAreThoseFoundWithoutTiles) {
  run_well(refine("tiles"));
  run_well(refine("whole", {"--no-keep-features"}));
  const SparseModel tiles = read_sparse_model(directory_ + "/tiles/sparse");
  const SparseModel whole = read_sparse_model(directory_ + "/whole/sparse");
  const SparseModel coarse = read_sparse_model(world_path("coarse_small"));
  ASSERT_EQ(tiles.images.size(), whole.images.size());
  std::vector<double> apart_m, moved_m;
  for (size_t i = 0; i < whole.images.size(); ++i) {
    const Eigen::Vector3d center = camera_center(whole.images[i].camera_from_map);
    apart_m.push_back((camera_center(tiles.images[i].camera_from_map) - center).norm());
    moved_m.push_back((camera_center(coarse.images[i].camera_from_map) - center).norm());
  }
  const auto middle = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  RecordProperty("median_apart_mm", std::to_string(1e3 * middle(apart_m)));
  EXPECT_LT(middle(apart_m), 0.2 * middle(moved_m)) << middle(apart_m) << " m of " << middle(moved_m) << " m";
}

TEST_F(StoredFeatures, ARunKilledAtRandomMomentsLeavesNothingThatIsTakenForWhole) {
  const Stopwatch watch;
  run_well(refine("whole"));
  const double seconds = 1e-3 * watch.milliseconds();
  const std::vector<std::string> files = tile_files();
  std::vector<std::string> contents;
  for (const std::string& file : files) contents.push_back(read_file(file));
  fs::remove_all(map_ + ".features");
  Random random(5);
  for (int i = 0; i < 5; ++i) {
    run_cpplus_and_kill(refine("killed"), [&] {
      std::this_thread::sleep_for(std::chrono::duration<double>(random.uniform(0.0, 0.6 * seconds)));
    });
  }
  run_well(refine("killed"));
  EXPECT_EQ(poses_of("killed"), poses_of("whole"));
  ASSERT_EQ(tile_files(), files) << "no temporaries are left";
  for (size_t i = 0; i < files.size(); ++i) EXPECT_TRUE(read_file(files[i]) == contents[i]) << files[i];
}

}  // namespace
}  // namespace cpplus
