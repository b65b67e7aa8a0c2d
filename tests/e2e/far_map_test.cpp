// A map with parts that no image is near: the results are those of the near part alone.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "cpplus/io/point_cloud_io.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

using Arguments = std::vector<std::string>;

/// The world's map, each of its points followed by two others hundreds of metres off, of which one is brighter.
PointCloud with_far_parts(const PointCloud& near) {
  PointCloud cloud;
  cloud.origin = near.origin;
  for (size_t i = 0; i < near.size(); ++i) {
    for (const float distance_m : {0.0f, 400.0f, -700.0f}) {
      cloud.positions.push_back(near.positions[i] + Eigen::Vector3f(distance_m, 0.5f * distance_m, 0.0f));
      cloud.intensities.push_back(near.intensities[i] * (distance_m > 0.0f ? 3.0f : 1.0f));
    }
  }
  return cloud;
}

/// The maps of a test: the world's own, with far parts, and the voxel map of these.
class FarMap : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = make_test_directory();
    near_cloud_ = read_point_cloud(world_path("map.pcd"));
    write_point_cloud(directory_ + "/far.pcd", with_far_parts(near_cloud_));
    run_well({"index", directory_ + "/far.pcd", "--out", directory_ + "/far.vox"});
  }

  std::string directory_;
  PointCloud near_cloud_;
};

TEST_F(FarMap, RefineFindsTheSamePoses) {
  const auto refine = [&](const std::string& map, const std::string& name) {
    const std::string out = directory_ + "/" + name;
    run_well({"refine", "--map", map, "--images", world_path("images"), "--poses", world_path("coarse_small"),
              "--stamps", world_path("stamps.txt"), "--no-keep-features", "--out", out});
    auto report = nlohmann::json::parse(read_file(out + "/report.json"));
    for (auto& image : report["images"]) image.erase("milliseconds");
    return std::pair(read_file(out + "/sparse/images.txt"), report);
  };
  const auto [poses, report] = refine(world_path("map.pcd"), "refined_near");
  EXPECT_EQ(report["map"]["points"], near_cloud_.size());
  for (const char* map : {"far.pcd", "far.vox"}) {
    const auto [far_poses, far_report] = refine(directory_ + "/" + map, std::string("refined_") + map);
    EXPECT_EQ(far_poses, poses) << map;
    EXPECT_EQ(far_report["images"], report["images"]) << map;
    EXPECT_EQ(far_report["map"]["points"], 3 * near_cloud_.size()) << map;
    EXPECT_EQ(far_report["map"]["planes"], report["map"]["planes"]) << map;
  }
}

TEST_F(FarMap, ColorizeGivesThemTheSameColoursAndWritesAllPoints) {
  const auto colorize = [&](const std::string& map, const std::string& name) {
    const std::string out = directory_ + "/" + name;
    run_well({"colorize", "--map", map, "--images", world_path("images"), "--poses", world_path("truth/on_map"),
              "--hold-out", "4", "--report", out + ".json", "--debug-images", out + "_debug", "--out", out});
    return read_point_cloud(out);
  };
  const PointCloud near = colorize(world_path("map.pcd"), "near.ply");
  const PointCloud far = colorize(directory_ + "/far.pcd", "far.ply");
  ASSERT_EQ(near.size(), near_cloud_.size());
  ASSERT_EQ(far.size(), 3 * near.size());
  size_t num_seen = 0;
  for (size_t i = 0; i < near.size(); ++i) {
    ASSERT_EQ(far.positions[3 * i], near.positions[i]);
    ASSERT_EQ(far.num_views[3 * i], near.num_views[i]) << i;
    ASSERT_EQ(far.best_images[3 * i], near.best_images[i]) << i;
    if (near.num_views[i] > 0) {
      ++num_seen;
      ASSERT_EQ(far.colors[3 * i], near.colors[i]) << i;
      ASSERT_EQ(far.color_spreads[3 * i], near.color_spreads[i]) << i;
    } else {
      ASSERT_EQ(far.colors[3 * i], far.colors[3 * i + 2]) << "grey of the same intensity";
    }
    for (const size_t beside : {3 * i + 1, 3 * i + 2}) {
      ASSERT_EQ(far.num_views[beside], 0);
      ASSERT_EQ(far.best_images[beside], 0u);
    }
  }
  EXPECT_GT(num_seen, near.size() / 4);
  EXPECT_EQ(read_file(directory_ + "/far.ply.json"), read_file(directory_ + "/near.ply.json"));
  colorize(directory_ + "/far.vox", "far_vox.ply");
  EXPECT_TRUE(read_file(directory_ + "/far_vox.ply") == read_file(directory_ + "/far.ply"));
}

}  // namespace
}  // namespace cpplus
