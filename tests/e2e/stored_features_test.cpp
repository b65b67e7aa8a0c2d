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

// Planes and edges differ a little where tiles meet, so poses do by some millimetres; none is the better one.
TEST_F(StoredFeatures, PosesAreAsGoodAsThoseFoundWithoutTiles) {
  run_well(refine("tiles"));
  run_well(refine("whole", {"--no-keep-features"}));
  const SparseModel truth = read_sparse_model(world_path("truth/on_map"));
  const auto median_error_m = [&](const std::string& model) {
    const SparseModel found = read_sparse_model(model);
    EXPECT_EQ(found.images.size(), truth.images.size());
    std::vector<double> errors_m;
    for (size_t i = 0; i < truth.images.size(); ++i) {
      EXPECT_EQ(found.images[i].name, truth.images[i].name);
      errors_m.push_back(
          (camera_center(found.images[i].camera_from_map) - camera_center(truth.images[i].camera_from_map)).norm());
    }
    std::sort(errors_m.begin(), errors_m.end());
    return errors_m[errors_m.size() / 2];
  };
  const double before_m = median_error_m(world_path("coarse_small"));
  const double tiles_m = median_error_m(directory_ + "/tiles/sparse");
  const double whole_m = median_error_m(directory_ + "/whole/sparse");
  RecordProperty("median_error_mm", std::to_string(1e3 * tiles_m) + ", whole " + std::to_string(1e3 * whole_m));
  EXPECT_LT(whole_m, 0.5 * before_m);
  EXPECT_NEAR(tiles_m, whole_m, 0.1 * before_m);
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
