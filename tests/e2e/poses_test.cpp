// Coarse poses from the scans' trajectory of the simulated world, and what follows from them.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "cpplus/io/colmap_io.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

ProcessResult poses(const std::string& rig, const std::string& out) {
  return run_cpplus({"poses", "--trajectory", world_path("scans/poses.txt"), "--rig", rig, "--images",
                     world_path("images"), "--stamps", world_path("stamps.txt"), "--max-gap-s", "3", "--out", out});
}

/// The world's scans are about a second apart and the sensor sways at 1.8 Hz, so the poses between them are rough.
TEST(Poses, AreNearTheTruthInASimulatedWorld) {
  const std::string directory = make_test_directory();
  const std::string out = directory + "/coarse";
  const ProcessResult result = poses(write_world_rig(directory + "/rig.yaml", inverse(world_lidar_from_camera())), out);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const SparseModel model = read_sparse_model(out);
  const SparseModel truth = read_sparse_model(world_path("truth"));
  EXPECT_GE(model.images.size(), truth.images.size() - 2)
      << "all but what lies before the first scan and after the last";
  EXPECT_EQ(model.cameras.begin()->second.params(), truth.cameras.begin()->second.params());
  for (const PosedImage& image : model.images) {
    for (const PosedImage& true_image : truth.images) {
      if (true_image.name != image.name) continue;
      EXPECT_LT((camera_center(image.camera_from_map) - camera_center(true_image.camera_from_map)).norm(), 0.1)
          << image.name;
      EXPECT_LT(rotation_angle_between(image.camera_from_map, true_image.camera_from_map), 3.0 * M_PI / 180.0)
          << image.name;
    }
  }
}

TEST(Poses, TheWorldsExtrinsicTheOtherWayRoundIsWarnedOf) {
  const std::string directory = make_test_directory();
  const ProcessResult result =
      poses(write_world_rig(directory + "/rig.yaml", world_lidar_from_camera()), directory + "/coarse");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("if its extrinsic is inverted"));
}

}  // namespace
}  // namespace cpplus
