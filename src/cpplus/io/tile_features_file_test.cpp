#include "cpplus/io/tile_features_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cpplus/core/error.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

TileFeatures some_features() {
  TileFeatures features;
  features.noise_m = 0.007;
  features.num_points = 12345;
  features.planes.resize(2);
  features.planes[1].plane = {{0.6, 0.0, 0.8}, {1.0, 2.0, 3.0}, 0.004, 99};
  features.planes[1].own.count = 55;
  features.planes[1].own.mean = {4.0, 5.0, 6.0};
  features.planes[1].own.covariance(2, 1) = 0.25;
  features.patches = {{7, 1, {0.5f, 0.25f, 0.125f}}};
  features.patches_around = {{8, 0, {1.5f, 1.25f, 1.125f}}, {9, 1, {2.5f, 0.0f, 0.0f}}};
  features.edges.resize(1);
  features.edges[0].kind = MapEdgeKind::kIntensity;
  features.edges[0].end = {0.0, 1.5, 0.0};
  features.edges[0].inward_b = {0.0, 0.0, -1.0};
  features.edges[0].covariance(0, 2) = 1e-5;
  features.edges[0].group = 3;
  features.leaf_spacing = {0.01f, 0.02f};
  return features;
}

class TileFeaturesFile : public FileTest {
 protected:
  /// What is said of the file after a change of its bytes.
  template <typename Change>
  std::string answer_after(const Change& change) {
    write_tile_features(path_, "a key", some_features());
    std::string bytes = read("some.tile");
    change(&bytes);
    write("some.tile", bytes);
    try {
      return read_tile_features(path_, "a key") ? "read" : "another's";
    } catch (const Error& error) {
      return error.what();
    }
  }

  std::string path_ = path("some.tile");
};

TEST_F(TileFeaturesFile, KeepsEverything) {
  const TileFeatures written = some_features();
  write_tile_features(path_, "a key", written);
  const auto found = read_tile_features(path_, "a key");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->noise_m, written.noise_m);
  EXPECT_EQ(found->num_points, written.num_points);
  ASSERT_EQ(found->planes.size(), 2u);
  EXPECT_EQ(found->planes[1].plane.normal, written.planes[1].plane.normal);
  EXPECT_EQ(found->planes[1].plane.centroid, written.planes[1].plane.centroid);
  EXPECT_EQ(found->planes[1].plane.sigma_m, written.planes[1].plane.sigma_m);
  EXPECT_EQ(found->planes[1].plane.num_points, written.planes[1].plane.num_points);
  EXPECT_EQ(found->planes[1].own.count, written.planes[1].own.count);
  EXPECT_EQ(found->planes[1].own.mean, written.planes[1].own.mean);
  EXPECT_EQ(found->planes[1].own.covariance, written.planes[1].own.covariance);
  ASSERT_EQ(found->patches.size(), 1u);
  ASSERT_EQ(found->patches_around.size(), 2u);
  EXPECT_EQ(found->patches_around[1].leaf, 9u);
  EXPECT_EQ(found->patches_around[1].plane, 1);
  EXPECT_EQ(found->patches_around[1].center, written.patches_around[1].center);
  ASSERT_EQ(found->edges.size(), 1u);
  EXPECT_EQ(found->edges[0].kind, MapEdgeKind::kIntensity);
  EXPECT_EQ(found->edges[0].end, written.edges[0].end);
  EXPECT_EQ(found->edges[0].inward_b, written.edges[0].inward_b);
  EXPECT_EQ(found->edges[0].covariance, written.edges[0].covariance);
  EXPECT_EQ(found->edges[0].group, 3u);
  EXPECT_EQ(found->leaf_spacing, written.leaf_spacing);
}

TEST_F(TileFeaturesFile, OfAnotherKeyOrVersionOrNoneIsNotRead) {
  EXPECT_FALSE(read_tile_features(path_, "a key"));
  write_tile_features(path_, "a key", some_features());
  EXPECT_FALSE(read_tile_features(path_, "b key"));
  EXPECT_FALSE(read_tile_features(path_, "a ke"));
  EXPECT_EQ(answer_after([](std::string* bytes) { (*bytes)[12] = 9; }), "another's");
  EXPECT_EQ(answer_after([](std::string*) {}), "read");
}

TEST_F(TileFeaturesFile, ADamagedOneIsNamed) {
  using testing::HasSubstr;
  EXPECT_THAT(answer_after([](std::string* bytes) { bytes->resize(20); }), HasSubstr(path_ + ": truncated: 20 bytes"));
  EXPECT_THAT(answer_after([](std::string* bytes) { bytes->pop_back(); }), HasSubstr(" bytes instead of "));
  EXPECT_THAT(answer_after([](std::string* bytes) { bytes->back() ^= 1; }), HasSubstr("damaged: wrong checksum"));
  EXPECT_THAT(answer_after([](std::string* bytes) { (*bytes)[0] = 'x'; }), HasSubstr("not a file of planes and edges"));
}

}  // namespace
}  // namespace cpplus
