#include "cpplus/io/pcd_writer.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/point_cloud_io.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

std::string file_in_temp(const std::string& name) { return testing::TempDir() + "/pcd_writer_test_" + name; }

PointCloud some_points(size_t count, float first) {
  PointCloud cloud;
  for (size_t i = 0; i < count; ++i) {
    cloud.positions.emplace_back(first + static_cast<float>(i), -1.0f, 2.0f);
    cloud.intensities.push_back(first);
  }
  return cloud;
}

TEST(PcdWriter, BlocksReadBackAsOneCloud) {
  const std::string path = file_in_temp("blocks.pcd");
  fs::remove(path);
  PcdWriter writer(path);
  for (const size_t count : {size_t{7}, size_t{0}, size_t{300000}, size_t{1}}) {
    writer.add(some_points(count, static_cast<float>(count)));
  }
  EXPECT_FALSE(fs::exists(path));
  writer.commit();
  EXPECT_EQ(writer.num_points(), 300008u);
  const PointCloud cloud = read_point_cloud(path);
  ASSERT_EQ(cloud.size(), 300008u);
  EXPECT_EQ(cloud.point(3).x(), 10.0);
  EXPECT_EQ(cloud.point(7).x(), 300000.0);
  EXPECT_EQ(cloud.point(300007).x(), 1.0);
  EXPECT_EQ(cloud.intensities[300006], 300000.0f);
}

TEST(PcdWriter, TheFileIsThatOfAWriterThatKnowsTheNumberButForPadding) {
  const PointCloud cloud = some_points(12, 0.5f);
  write_point_cloud(file_in_temp("known.pcd"), cloud);
  PcdWriter writer(file_in_temp("unknown.pcd"));
  writer.add(cloud);
  writer.commit();
  // Room for two numbers of 20 digits where there are 2.
  EXPECT_EQ(fs::file_size(file_in_temp("unknown.pcd")), fs::file_size(file_in_temp("known.pcd")) + 2 * 18);
}

TEST(PcdWriter, WithoutCommitThereIsNothing) {
  const fs::path folder = file_in_temp("folder");
  fs::remove_all(folder);
  { PcdWriter((folder / "map.pcd").string()).add(some_points(5, 0.0f)); }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(PcdWriter, AFullDiskIsToldAtOnce) {
  if (!fs::exists("/dev/full")) GTEST_SKIP();
  // The temporary of a file in a folder cannot be /dev/full; a link in its place is.
  const std::string path = file_in_temp("full.pcd");
  fs::remove(temporary_path(path));
  fs::create_symlink("/dev/full", temporary_path(path));
  PcdWriter writer(path);
  EXPECT_THROW(writer.add(some_points(300000, 0.0f)), Error);
}

}  // namespace
}  // namespace cpplus
