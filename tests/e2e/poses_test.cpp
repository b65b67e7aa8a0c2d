// Coarse poses from the scans' trajectory of the simulated world, and what follows from them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cpplus/io/colmap_io.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

std::string world(const std::string& name) { return std::string(CPPLUS_E2E_WORLD) + "/" + name; }

/// The world's true extrinsic, which is written as lidar_from_camera.
Rigid3 lidar_from_camera() {
  const nlohmann::json rows = nlohmann::json::parse(read_file(world("truth/extrinsic.json"))).at("T_lidar_cam");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = rows[static_cast<size_t>(i / 4)][static_cast<size_t>(i % 4)];
  return Rigid3(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
}

std::string write_rig(const std::string& file, const Rigid3& camera_from_lidar) {
  const Camera camera = read_sparse_model(world("truth")).cameras.begin()->second;
  const Eigen::Quaterniond& q = camera_from_lidar.rotation;
  const Eigen::Vector3d& t = camera_from_lidar.translation;
  write_file(file, fmt::format("cameras:\n  front:\n    model: {}\n    width: {}\n    height: {}\n    params: [{}]\n"
                               "    top_left_pixel: 0\n    camera_from_lidar:\n"
                               "      quaternion_wxyz: [{}, {}, {}, {}]\n      translation: [{}, {}, {}]\n",
                               camera_model_name(camera.model()), camera.width(), camera.height(),
                               fmt::join(camera.params(), ", "), q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()));
  return file;
}

ProcessResult poses(const std::string& rig, const std::string& out) {
  return run_cpplus({"poses", "--trajectory", world("scans/poses.txt"), "--rig", rig, "--images", world("images"),
                     "--stamps", world("stamps.txt"), "--max-gap-s", "3", "--out", out});
}

/// The world's scans are about a second apart and the sensor sways at 1.8 Hz, so the poses between them are rough.
TEST(Poses, AreNearTheTruthInASimulatedWorld) {
  const std::string directory = make_test_directory();
  const std::string out = directory + "/coarse";
  const ProcessResult result = poses(write_rig(directory + "/rig.yaml", inverse(lidar_from_camera())), out);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const SparseModel model = read_sparse_model(out);
  const SparseModel truth = read_sparse_model(world("truth"));
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
  const ProcessResult result = poses(write_rig(directory + "/rig.yaml", lidar_from_camera()), directory + "/coarse");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("if its extrinsic is inverted"));
}

}  // namespace
}  // namespace cpplus
