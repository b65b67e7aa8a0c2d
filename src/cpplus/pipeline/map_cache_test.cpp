#include "cpplus/pipeline/map_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/map_io.h"
#include "cpplus/io/point_cloud_io.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

class MapCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "cache_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    write_map(1.0f);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_map(float x) const {
    PointCloud cloud;
    cloud.positions = {{x, 2.0f, 3.0f}};
    write_point_cloud(map(), cloud);
  }
  std::string map() const { return folder_ + "/map.pcd"; }
  std::string cache() const { return folder_ + "/cache"; }

  std::string folder_;
};

TEST_F(MapCacheTest, MakesTheFileOnceAndKeepsIt) {
  const std::string first = cached_map(map(), cache(), {});
  EXPECT_EQ(read_map(first, {}).map.point(0), Eigen::Vector3d(1, 2, 3));
  const auto made = fs::last_write_time(first);
  EXPECT_EQ(cached_map(map(), cache(), {}), first);
  EXPECT_EQ(fs::last_write_time(first), made);
}

TEST_F(MapCacheTest, MakesAnotherForAChangedMapAndForOtherVoxels) {
  const std::string first = cached_map(map(), cache(), {});
  write_map(7.0f);
  fs::last_write_time(map(), fs::last_write_time(map()) + std::chrono::seconds(2));
  const std::string second = cached_map(map(), cache(), {});
  EXPECT_NE(second, first);
  EXPECT_EQ(read_map(second, {}).map.point(0), Eigen::Vector3d(7, 2, 3));
  const VoxelMapOptions coarse = {4.0, 0.5};
  EXPECT_EQ(read_map(cached_map(map(), cache(), coarse), coarse).map.options().leaf_size_m, 0.5);
}

TEST_F(MapCacheTest, NoFolderAndAVoxelMapNeedNone) {
  EXPECT_EQ(cached_map(map(), "", {}), map());
  EXPECT_EQ(cached_map(folder_ + "/none.vox", cache(), {}), folder_ + "/none.vox");
  EXPECT_FALSE(fs::exists(cache()));
}

TEST_F(MapCacheTest, AMapThatDoesNotExistIsNamed) {
  EXPECT_THROW(
      {
        try {
          cached_map(folder_ + "/none.pcd", cache(), {});
        } catch (const Error& error) {
          EXPECT_THAT(error.what(), testing::HasSubstr("none.pcd: cannot read: No such file"));
          throw;
        }
      },
      Error);
  EXPECT_FALSE(fs::exists(cache()));
}

}  // namespace
}  // namespace cpplus
