#include "cpplus/pipeline/feature_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "cpplus/core/error.h"
#include "cpplus/features/test_surfaces.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/pipeline/index_command.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A floor with a wall along one side, 18 m long: two tiles.
PointCloud floor_and_wall(uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  add_surface({0.1, 0.1, 0.3}, {17.8, 0, 0}, {0, 1.7, 0}, 500, 0.005, &random, &cloud);
  add_surface({0.1, 0.1, 0.3}, {17.8, 0, 0}, {0, 0, 1.4}, 500, 0.005, &random, &cloud);
  return cloud;
}

class FeatureStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "store_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    options_.max_points = 20000;
    write_map(1);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_map(uint64_t seed) const {
    write_point_cloud(folder_ + "/map.pcd", floor_and_wall(seed));
    IndexCommandOptions index;
    index.out = map();
    index_command({folder_ + "/map.pcd"}, index);
  }

  std::string map() const { return folder_ + "/map.vox"; }

  FeatureStore open() const { return {map(), read_map(map(), {}), stages_, options_}; }

  /// The features of all roots, and how many tiles had to be looked at for it.
  std::pair<MapFeatures, size_t> find() const {
    FeatureStore store = open();
    const PointMap points = read_map(map(), {});
    std::vector<uint32_t> roots(points.map.num_nodes(0));
    std::iota(roots.begin(), roots.end(), 0u);
    MapFeatures features = store.find(roots, points.map);
    return {std::move(features), store.num_found()};
  }

  std::vector<std::string> tile_files() const {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(features_folder(map()))) files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    return files;
  }

  std::string folder_;
  RefineImagesOptions stages_;
  FeatureStoreOptions options_;
};

void expect_same_found(const MapFeatures& features, const MapFeatures& expected) {
  EXPECT_EQ(features.surface.leaves, expected.surface.leaves);
  EXPECT_EQ(features.surface.plane_of, expected.surface.plane_of);
  EXPECT_EQ(features.surface.centers, expected.surface.centers);
  EXPECT_EQ(features.leaf_spacing, expected.leaf_spacing);
  EXPECT_EQ(features.planes.noise_m, expected.planes.noise_m);
  ASSERT_EQ(features.edges.size(), expected.edges.size());
  for (size_t i = 0; i < features.edges.size(); ++i) {
    EXPECT_EQ(features.edges[i].start, expected.edges[i].start);
    EXPECT_EQ(features.edges[i].normal_b, expected.edges[i].normal_b);
    EXPECT_EQ(features.edges[i].group, expected.edges[i].group);
  }
}

TEST_F(FeatureStoreTest, FindsThemOnce) {
  const auto [first, num_found] = find();
  EXPECT_EQ(num_found, 2u);
  EXPECT_GT(first.edges.size(), 8u);
  EXPECT_EQ(tile_files().size(), 2u);
  const auto [second, num_found_again] = find();
  EXPECT_EQ(num_found_again, 0u);
  expect_same_found(second, first);
}

TEST_F(FeatureStoreTest, FindAllLeavesNothingToFind) {
  FeatureStore store = open();
  store.find_all();
  EXPECT_EQ(store.num_found(), 2u);
  EXPECT_EQ(find().second, 0u);
}

TEST_F(FeatureStoreTest, LooksOnlyAtTheTilesAsked) {
  FeatureStore store = open();
  const PointMap points = read_map(map(), {});
  store.find({0}, points.map);
  EXPECT_EQ(store.num_found(), 1u);
  EXPECT_EQ(tile_files().size(), 1u);
}

TEST_F(FeatureStoreTest, LookedAtBeforehandTheyAreTheSame) {
  const auto [expected, num_found] = find();
  remove_features(map());
  FeatureStore store = open();
  const PointMap points = read_map(map(), {});
  std::vector<uint32_t> roots(points.map.num_nodes(0));
  std::iota(roots.begin(), roots.end(), 0u);
  store.look_at({0});
  EXPECT_EQ(store.num_found(), 1u);
  EXPECT_EQ(tile_files().size(), 1u);
  store.look_at(roots);
  store.look_at(roots);
  EXPECT_EQ(store.num_found(), num_found);
  expect_same_found(store.find(roots, points.map), expected);
  EXPECT_EQ(store.num_found(), num_found) << "nothing twice";
  EXPECT_EQ(store.num_read(), 0u) << "nothing was there before";
}

TEST_F(FeatureStoreTest, OtherOptionsDoNotTakeThem) {
  find();
  stages_.planes.max_distance_sigmas = 2.5;
  EXPECT_EQ(find().second, 2u);
  stages_.map_edges.crease.min_length_m = 0.5;
  EXPECT_EQ(find().second, 2u);
  options_.halo_m = 6.0;
  EXPECT_EQ(find().second, 2u);
  stages_ = {};
  options_.halo_m = 4.0;
  EXPECT_EQ(find().second, 0u) << "those of the first options are still there";
  stages_.samples.spacing_px = 3.0;
  EXPECT_EQ(find().second, 0u) << "nothing of them is found with this one";
}

TEST_F(FeatureStoreTest, AnotherMapOfTheSameNameDoesNotTakeThem) {
  const auto [first, num_found] = find();
  write_map(2);
  const auto [second, num_found_again] = find();
  EXPECT_EQ(num_found_again, 2u);
  EXPECT_NE(second.surface.centers, first.surface.centers);
}

TEST_F(FeatureStoreTest, IndexFindsAllIfAskedAndRemovesThoseOfTheMapBefore) {
  find();
  IndexCommandOptions index;
  index.out = map();
  index_command({folder_ + "/map.pcd"}, index);
  EXPECT_FALSE(fs::exists(features_folder(map())));
  index.features = true;
  index.tiles = options_;
  index.planes.max_distance_sigmas = stages_.planes.max_distance_sigmas = 2.5;
  index.map_edges.crease.min_length_m = stages_.map_edges.crease.min_length_m = 0.5;
  index_command({folder_ + "/map.pcd"}, index);
  EXPECT_EQ(find().second, 0u);
}

TEST_F(FeatureStoreTest, DamagedOnesAreMadeAnew) {
  const auto [first, num_found] = find();
  const std::string file = tile_files()[0];
  for (const auto size : {fs::file_size(file) - 5, std::uintmax_t{10}}) {
    fs::resize_file(file, size);
    testing::internal::CaptureStderr();
    const auto [again, num_found_again] = find();
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("warning: " + file + ": "));
    EXPECT_EQ(num_found_again, 1u);
    expect_same_found(again, first);
  }
  std::fstream(file, std::ios::in | std::ios::out).seekp(500).put('x');
  testing::internal::CaptureStderr();
  EXPECT_EQ(find().second, 1u);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("damaged: wrong checksum; it is made anew"));
  EXPECT_EQ(find().second, 0u);
}

TEST_F(FeatureStoreTest, AFolderThatCannotBeWrittenIsSaidOnce) {
  std::ofstream(features_folder(map())) << "a file in its place";
  testing::internal::CaptureStderr();
  const auto [features, num_found] = find();
  const std::string warnings = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(warnings.begin(), warnings.end(), '\n'), 1) << warnings;
  EXPECT_THAT(warnings, HasSubstr("planes and edges of the map are not kept"));
  EXPECT_EQ(num_found, 2u);
  EXPECT_GT(features.edges.size(), 8u);
}

TEST_F(FeatureStoreTest, OptionsOutOfRangeAreNamed) {
  options_.halo_m = 0.5;
  EXPECT_THROW(options_.validate(), UsageError);
  options_ = {};
  options_.max_points = 0;
  EXPECT_THROW(options_.validate(), UsageError);
}

}  // namespace
}  // namespace cpplus
