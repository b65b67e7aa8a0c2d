#include "cpplus/pipeline/write_world.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/trajectory_io.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

SimulateOptions small_room() {
  SimulateOptions options;
  options.width = 160;
  options.height = 120;
  options.images = 3;
  options.scans = 3;
  options.lidar.azimuth_steps = 360;
  options.lidar.rings = 16;
  options.render.samples_per_pixel = 1;
  return options;
}

nlohmann::json read_json(const fs::path& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

TEST(WriteWorld, EveryFileReadsBackAsWhatWasSimulated) {
  const fs::path folder = fs::path(testing::TempDir()) / "write_world_test";
  fs::remove_all(folder);
  const SimulatedWorld world = simulate_world(small_room());
  const SimulationSummary summary = write_world(world, folder.string());
  EXPECT_EQ(summary.images, 3u);
  EXPECT_EQ(summary.scans, 3u);
  EXPECT_EQ(summary.map_points, world.map.size());
  EXPECT_EQ(summary.checkerboards, 3u);

  EXPECT_EQ(read_point_cloud((folder / "map.pcd").string()).size(), world.map.size());
  EXPECT_EQ(fs::file_size(folder / "truth/map.label"), world.map.size());
  EXPECT_EQ(read_point_cloud((folder / "scans/000002.pcd").string()).size(), world.scans[2].scan.points.size());
  EXPECT_EQ(fs::file_size(folder / "scans/000002.label"), world.scans[2].scan.points.size());
  const Trajectory poses = read_tum((folder / "scans/poses.txt").string());
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_LT((poses[1].map_from_sensor.translation - world.scans[1].map_from_lidar.translation).norm(), 1e-9);

  const auto stamps = read_stamps((folder / "stamps.txt").string());
  EXPECT_NEAR(stamps.at("000001.jpg"), world.images[1].stamp_s, 1e-6);
  const ColorImage image = read_color_image((folder / "images/000001.jpg").string());
  EXPECT_EQ(image.width, 160);
  EXPECT_EQ(image.height, 120);

  for (const char* name : {"truth", "truth/on_map", "coarse_small", "coarse_medium", "coarse_large"}) {
    const SparseModel model = read_sparse_model((folder / name).string());
    ASSERT_EQ(model.images.size(), 3u) << name;
    EXPECT_EQ(model.cameras.at(1).params(), world.camera.params()) << name;
  }
  const SparseModel truth = read_sparse_model((folder / "truth").string());
  EXPECT_LT(camera_difference(truth.images[2].camera_from_map, world.images[2].camera_from_map).norm(), 1e-9);

  const nlohmann::json edges = read_json(folder / "truth/edges.json");
  EXPECT_EQ(edges["edges"].size(), summary.true_edges);
  const nlohmann::json boards = read_json(folder / "truth/checkerboards.json");
  ASSERT_EQ(boards["boards"].size(), 3u);
  EXPECT_EQ(boards["boards"][0]["corners_3d"].size(), 40u);
  EXPECT_TRUE(fs::exists(folder / "truth/depth/000000.npz"));
  EXPECT_TRUE(fs::exists(folder / "truth/blurred.txt"));
}

TEST(WriteWorld, AFolderThatCannotBeMadeIsNamed) {
  const fs::path file = fs::path(testing::TempDir()) / "write_world_test_file";
  std::ofstream(file) << "x";
  try {
    simulate(small_room(), (file / "inside").string());
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
  }
}

}  // namespace
}  // namespace cpplus
