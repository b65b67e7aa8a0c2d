#include "cpplus/io/cloud_source.h"

#include <limits>

#include "cpplus/core/random.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using CloudSourceTest = FileTest;

/// All points of a file by blocks of at most this many.
PointCloud read_by_blocks(const std::string& path, size_t max_points, size_t* num_dropped = nullptr) {
  CloudBlocks blocks(path);
  PointCloud all, block;
  while (blocks.next(max_points, &block)) {
    EXPECT_LE(block.size(), max_points);
    if (block.empty()) continue;
    EXPECT_TRUE(all.empty() || block.origin == all.origin);
    all.origin = block.origin;
    const auto append = [](auto* to, const auto& from) { to->insert(to->end(), from.begin(), from.end()); };
    append(&all.positions, block.positions);
    append(&all.intensities, block.intensities);
    append(&all.colors, block.colors);
    append(&all.stamps_s, block.stamps_s);
    append(&all.num_views, block.num_views);
    append(&all.best_images, block.best_images);
    append(&all.color_spreads, block.color_spreads);
  }
  if (num_dropped != nullptr) *num_dropped = blocks.num_dropped();
  return all;
}

void expect_blocks_make_the_whole(const std::string& path) {
  ReadCounts counts;
  const PointCloud whole = read_point_cloud(path, &counts);
  for (const size_t max_points : {size_t{1}, size_t{3}, whole.size(), size_t{1000}}) {
    size_t num_dropped = 0;
    const PointCloud all = read_by_blocks(path, max_points, &num_dropped);
    EXPECT_EQ(num_dropped, counts.dropped_non_finite);
    EXPECT_EQ(all.origin, whole.origin) << path;
    EXPECT_EQ(all.positions, whole.positions) << path << ", blocks of " << max_points;
    EXPECT_EQ(all.intensities, whole.intensities);
    EXPECT_EQ(all.colors, whole.colors);
    EXPECT_EQ(all.stamps_s, whole.stamps_s);
    EXPECT_EQ(all.num_views, whole.num_views);
    EXPECT_EQ(all.best_images, whole.best_images);
    EXPECT_EQ(all.color_spreads, whole.color_spreads);
  }
}

/// Far from zero, with every attribute.
PointCloud far_cloud() {
  Random random(3);
  PointCloud cloud;
  cloud.origin = {600000.0, 5000000.0, 0.0};
  for (size_t i = 0; i < 20; ++i) {
    cloud.positions.emplace_back(random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(0, 5));
    cloud.intensities.push_back(static_cast<float>(random.below(256)));
    cloud.colors.push_back({static_cast<uint8_t>(random.next()), 0, 255});
    cloud.stamps_s.push_back(0.25 * static_cast<double>(i));
    cloud.num_views.push_back(static_cast<uint16_t>(i));
    cloud.best_images.push_back(static_cast<uint32_t>(100000 * i));
    cloud.color_spreads.push_back(static_cast<uint8_t>(i));
  }
  return cloud;
}

TEST_F(CloudSourceTest, BlocksMakeTheWholeCloud) {
  for (const char* name : {"a.pcd", "a.ply", "a.las"}) {
    write_point_cloud(path(name), far_cloud());
    expect_blocks_make_the_whole(path(name));
  }
}

TEST_F(CloudSourceTest, SoDoThoseOfTextFiles) {
  const std::string points = "nan 0 0 1\n1 2 3 4\n\n5 6 7 8\n9 10 inf 12\n13 14 15 16\n";
  expect_blocks_make_the_whole(
      write("t.pcd",
            "FIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 5\nHEIGHT 1\nPOINTS 5\n"
            "DATA ascii\n# more\n" +
                points));
  expect_blocks_make_the_whole(
      write("t.ply",
            "ply\nformat ascii 1.0\nelement other 2\nproperty int a\nelement vertex 5\nproperty float x\n"
            "property float y\nproperty float z\nproperty float intensity\nend_header\n7\n8\n" +
                points));
}

TEST_F(CloudSourceTest, SoDoThoseOfCompressedFiles) {
  // Columns x, y, a field without meaning, z, intensity; literal runs only.
  std::string columns;
  for (int field = 0; field < 5; ++field) {
    for (int i = 0; i < 8; ++i) columns += bytes_of(static_cast<float>(10 * field + i));
  }
  std::string packed;
  for (size_t i = 0; i < columns.size(); i += 32) packed += '\x1F' + columns.substr(i, 32);
  expect_blocks_make_the_whole(write("c.pcd",
                                     "FIELDS x y other z intensity\nSIZE 4 4 4 4 4\nTYPE F F F F F\n"
                                     "COUNT 1 1 1 1 1\nWIDTH 8\nHEIGHT 1\nPOINTS 8\n"
                                     "DATA binary_compressed\n" +
                                         bytes_of(static_cast<uint32_t>(packed.size())) +
                                         bytes_of(static_cast<uint32_t>(columns.size())) + packed));
}

TEST_F(CloudSourceTest, ColorsOfEightBitsInLasStayAsTheyAreInEveryBlock) {
  PointCloud cloud = far_cloud();
  write_point_cloud(path("a.las"), cloud);
  std::string file = read("a.las");
  // The writer stores 257 times a colour: its low bytes are the colour in 8 bits.
  const PointCloud wide = read_by_blocks(path("a.las"), 7);
  EXPECT_EQ(wide.colors, cloud.colors);
  const size_t record_size = 34 + 7;  // format 3 and the extra bytes
  const size_t first_record = file.size() - cloud.size() * record_size;
  for (size_t i = 0; i < cloud.size(); ++i) {
    for (size_t channel = 0; channel < 3; ++channel) file[first_record + i * record_size + 28 + 2 * channel + 1] = '\0';
  }
  EXPECT_EQ(read_by_blocks(write("narrow.las", file), 7).colors, cloud.colors);
}

TEST_F(CloudSourceTest, FilesThatAreNotWholeAreErrors) {
  write_point_cloud(path("a.ply"), far_cloud());
  const std::string head =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n";
  EXPECT_ERROR(read_by_blocks(write("short.pcd", head + "1.0000 2.0000 3.0000\n"), 1),
               "short.pcd: truncated: 1 points");
  EXPECT_ERROR(read_by_blocks(write("long.pcd", head + "1 2 3\n4 5 6\n7 8 9\n"), 1),
               "long.pcd:11: more points than POINTS 2");
  EXPECT_ERROR(read_by_blocks(write("nan.pcd", head + "1 2 nan\nnan 5 6\n"), 1),
               "nan.pcd: none of its 2 points is finite");
  EXPECT_ERROR(read_by_blocks(path("none.pcd"), 1), "none.pcd: cannot read");
}

}  // namespace
}  // namespace cpplus
