#include "cpplus/io/pcd.h"

#include <cstring>
#include <sstream>

#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using PcdTest = FileTest;

std::string header(const std::string& fields, const std::string& sizes, const std::string& types,
                   const std::string& counts, size_t points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " + types + "\nCOUNT " + counts +
         "\nWIDTH " + std::to_string(points) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) +
         "\nDATA " + data + "\n";
}

const std::string kXyzAscii = header("x y z", "4 4 4", "F F F", "1 1 1", 2, "ascii");

TEST_F(PcdTest, AsciiWithAnyFieldOrderAndWindowsLineEnds) {
  const PointCloud cloud = read_point_cloud(
      write("a.pcd", header("intensity z _ y x t", "4 4 1 8 4 8", "F F U F F F", "1 1 2 1 1 1", 2, "ascii") +
                         "7 3 0 0 2 1 10.5\r\n\r\n8 -3 0 0 -2e0 -1 11\r\n"));
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.positions[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.positions[1], Eigen::Vector3f(-1, -2, -3));
  EXPECT_THAT(cloud.intensities, testing::ElementsAre(7, 8));
  EXPECT_THAT(cloud.stamps_s, testing::ElementsAre(10.5, 11));
  EXPECT_TRUE(cloud.colors.empty());
}

TEST_F(PcdTest, PackedColorsAsFloatBitsIntegerAndPlainDigits) {
  const uint32_t orange = 0xFF8001;
  float as_float;
  std::memcpy(&as_float, &orange, 4);
  const std::string xyz = bytes_of(1.f) + bytes_of(2.f) + bytes_of(3.f);
  const Rgb expected{255, 128, 1};
  for (const char* type : {"F", "U"}) {
    const std::string types = std::string("F F F ") + type;
    const PointCloud cloud = read_point_cloud(
        write("b.pcd", header("x y z rgb", "4 4 4 4", types, "1 1 1 1", 1, "binary") + xyz + bytes_of(orange)));
    EXPECT_EQ(cloud.colors.at(0), expected) << type;
  }
  const std::string ascii = header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 1, "ascii");
  EXPECT_EQ(read_point_cloud(write("c.pcd", ascii + "1 2 3 16744449\n")).colors.at(0), expected);
  const uint32_t dim = 0x3F8001;  // as a float 0.996..., a number with a point
  std::memcpy(&as_float, &dim, 4);
  std::ostringstream text;
  text.precision(9);
  text << as_float;
  EXPECT_EQ(read_point_cloud(write("d.pcd", ascii + "1 2 3 " + text.str() + "\n")).colors.at(0), (Rgb{63, 128, 1}));
}

TEST_F(PcdTest, SeparateColorChannelsAndNanosecondStamps) {
  const PointCloud cloud = read_point_cloud(
      write("e.pcd", header("x y z r g b t", "4 4 4 1 1 1 4", "F F F U U U U", "1 1 1 1 1 1 1", 1, "binary") +
                         bytes_of(1.f) + bytes_of(2.f) + bytes_of(3.f) + "\x01\x02\x03" + bytes_of(1500000000u)));
  EXPECT_EQ(cloud.colors.at(0), (Rgb{1, 2, 3}));
  EXPECT_DOUBLE_EQ(cloud.stamps_s.at(0), 1.5);
}

TEST_F(PcdTest, BinaryCompressedColumnsWithBackReferences) {
  // x = 1 1 1, y = 1 2 1, z = 0 0 0, intensity (u8) = 5 6 7; LZF by hand:
  // four literals (x0), a reference 4 back of length 8 (x1 x2), and so on.
  const std::string one = bytes_of(1.f), two = bytes_of(2.f);
  const auto literals = [](const std::string& bytes) {
    return std::string(1, static_cast<char>(bytes.size() - 1)) + bytes;
  };
  const auto reference = [](int distance, int length) {
    if (length < 9)
      return std::string{static_cast<char>((length - 2) << 5 | (distance - 1) >> 8), static_cast<char>(distance - 1)};
    return std::string{static_cast<char>(7 << 5 | (distance - 1) >> 8), static_cast<char>(length - 9),
                       static_cast<char>(distance - 1)};
  };
  const std::string packed = literals(one) + reference(4, 8) + reference(4, 4) + literals(two) + reference(8, 4) +
                             literals(std::string(1, '\0')) + reference(1, 11) + literals("\x05\x06\x07");
  const uint32_t decoded_size = 39;
  const std::string file = header("x y z intensity", "4 4 4 1", "F F F U", "1 1 1 1", 3, "binary_compressed") +
                           bytes_of(static_cast<uint32_t>(packed.size())) + bytes_of(decoded_size) + packed;
  const PointCloud cloud = read_point_cloud(write("f.pcd", file));
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.positions[0], Eigen::Vector3f(1, 1, 0));
  EXPECT_EQ(cloud.positions[1], Eigen::Vector3f(1, 2, 0));
  EXPECT_EQ(cloud.positions[2], Eigen::Vector3f(1, 1, 0));
  EXPECT_THAT(cloud.intensities, testing::ElementsAre(5, 6, 7));

  EXPECT_ERROR(read_point_cloud(write("cut.pcd", file.substr(0, file.size() - 2))), "cut.pcd: truncated");
  std::string corrupt = file;
  corrupt[file.size() - packed.size() + 6] = 100;  // refers back 101 bytes after 4
  EXPECT_ERROR(read_point_cloud(write("bad.pcd", corrupt)), "bad.pcd: corrupt compressed data");
  std::string lie = file;
  lie[file.size() - packed.size() - 4] = 40;
  EXPECT_ERROR(read_point_cloud(write("lie.pcd", lie)), "decoded size 40 is not POINTS 3 of 13 bytes");
}

TEST_F(PcdTest, NonFinitePointsAreDroppedAndCounted) {
  ReadCounts counts;
  const PointCloud cloud =
      read_point_cloud(write("n.pcd", header("x y z intensity", "4 4 4 4", "F F F F", "1 1 1 1", 4, "ascii") +
                                          "nan nan nan 1\n1 2 3 2\n1 inf 3 3\n4 5 6 4\n"),
                       &counts);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_THAT(cloud.intensities, testing::ElementsAre(2, 4));
  EXPECT_EQ(counts.in_file, 4u);
  EXPECT_EQ(counts.dropped_non_finite, 2u);
  EXPECT_ERROR(read_point_cloud(write("all.pcd", kXyzAscii + "nan 1 1\n1 nan 1\n")), "none of its 2 points is finite");
  EXPECT_ERROR(read_point_cloud(write("empty.pcd", header("x y z", "4 4 4", "F F F", "1 1 1", 0, "ascii"))),
               "holds no points");
}

TEST_F(PcdTest, WrittenCloudComesBackExactly) {
  PointCloud cloud;
  for (int i = 0; i < 1000; ++i) {
    cloud.positions.emplace_back(0.1f * static_cast<float>(i), -1.f / static_cast<float>(i + 1), 3.f);
    cloud.intensities.push_back(0.3f * static_cast<float>(i));
    cloud.colors.push_back({static_cast<uint8_t>(i), static_cast<uint8_t>(i / 3), 255});
    cloud.stamps_s.push_back(1.7e9 + 0.001 * i);
    cloud.num_views.push_back(static_cast<uint16_t>(i % 7));
    cloud.best_images.push_back(4000000000u - static_cast<uint32_t>(i));
    cloud.color_spreads.push_back(static_cast<uint8_t>(i % 251));
  }
  for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(691234, 5334567, 0)}) {
    cloud.origin = origin;
    write_point_cloud(path("w.pcd"), cloud);
    EXPECT_EQ(num_files(), 1u);
    const PointCloud back = read_point_cloud(path("w.pcd"));
    ASSERT_EQ(back.size(), cloud.size());
    for (size_t i = 0; i < cloud.size(); ++i) {
      // Double coordinates of 5e6 m carry 1e-9 m.
      ASSERT_LT((back.point(i) - cloud.point(i)).norm(), origin.isZero() ? 1e-30 : 4e-6) << i;
    }
    EXPECT_EQ(back.intensities, cloud.intensities);
    EXPECT_EQ(back.colors, cloud.colors);
    EXPECT_EQ(back.stamps_s, cloud.stamps_s);
    EXPECT_EQ(back.num_views, cloud.num_views);
    EXPECT_EQ(back.best_images, cloud.best_images);
    EXPECT_EQ(back.color_spreads, cloud.color_spreads);
  }
}

TEST_F(PcdTest, LargeCoordinatesGetARoundedOrigin) {
  const PointCloud cloud =
      read_point_cloud(write("utm.pcd", header("x y z", "8 8 8", "F F F", "1 1 1", 2, "ascii") +
                                            "691234.567 5334567.891 512.3\n691235.567 5334566.890 513.3\n"));
  EXPECT_EQ(cloud.origin, Eigen::Vector3d(691235, 5334568, 0));
  EXPECT_LT((cloud.point(1) - Eigen::Vector3d(691235.567, 5334566.890, 513.3)).norm(), 4e-5);
  EXPECT_NEAR(cloud.point(1).y(), 5334566.890, 1e-7);
}

TEST_F(PcdTest, LyingHeadersAndBrokenFilesAreErrors) {
  const auto expect = [&](const std::string& bytes, const std::string& text) {
    EXPECT_ERROR(read_point_cloud(write("bad.pcd", bytes)), text);
    EXPECT_ERROR(read_point_cloud(write("bad.pcd", bytes)), path("bad.pcd"));
  };
  expect("", "no DATA line");
  expect("hello world\n", "unknown header line 'hello world'");
  expect(kXyzAscii + "1.000 2.000 3.000\n", "truncated: 1 points instead of POINTS 2");
  expect(kXyzAscii + "1 2 3\n1 2 3\n1 2 3\n", ":14: more points than POINTS 2 says");
  expect(kXyzAscii + "1.5 2.5 3.5\n1 2\n", ":13: 2 numbers instead of 3");
  expect(kXyzAscii + "1 2 3\n1 2 3,5\n", ":13: z is not a number: '3,5'");
  expect(header("x y", "4 4", "F F", "1 1", 1, "ascii") + "1 2\n", "has no x, y and z: its fields are x y");
  expect(header("x y z", "4 4", "F F F", "1 1 1", 1, "ascii") + "1 2 3\n", "3 FIELDS but 2 SIZE");
  expect(header("x y z", "4 4 3", "F F F", "1 1 1", 1, "ascii") + "1 2 3\n", "TYPE 'F' with SIZE '3'");
  expect(header("x y z", "4 4 4", "F F F", "1 1 1", 1, "zipped"), "unknown DATA 'zipped'");
  expect(header("x y z", "4 4 4", "F F F", "1 1 -1", 1, "ascii"), "bad COUNT '-1' of z");
  expect(header("x y z", "4 4 4", "F F F", "1 1 1", 1000000000, "binary") + std::string(24, 'a'),
         "truncated: POINTS 1000000000 do not fit into the 24 bytes");
  expect(header("x y z", "4 4 4", "F F F", "1 1 1", 1000000000, "binary_compressed") + std::string(24, 'a'),
         "truncated: POINTS 1000000000 do not fit into the 24 bytes");
  std::string mismatch = header("x y z", "4 4 4", "F F F", "1 1 1", 2, "binary");
  mismatch.replace(mismatch.find("WIDTH 2"), 7, "WIDTH 3");
  expect(mismatch + std::string(36, 'a'), "POINTS 2 is not WIDTH 3 x HEIGHT 1");
}

TEST_F(PcdTest, FilesThatCannotBeReadOrWrittenAreErrors) {
  EXPECT_ERROR(read_point_cloud(path("none.pcd")), "none.pcd: cannot read: No such file or directory");
  EXPECT_ERROR(read_point_cloud(path("cloud.xyz")), "unknown point cloud extension '.xyz'");
  PointCloud cloud;
  cloud.positions.resize(2);
  EXPECT_ERROR(write_point_cloud(path("cloud.e57"), cloud), "unknown point cloud extension '.e57'");
  cloud.intensities.resize(1);
  EXPECT_ERROR(write_point_cloud(path("cloud.pcd"), cloud), "1 intensities for 2 points");
  EXPECT_ERROR(write_point_cloud("/proc/cloud.pcd", PointCloud()), "/proc/cloud.pcd: cannot write");
}

TEST(PcdSceneTest, RecordedMapIsReadWhole) {
  const std::string map = std::string(CPPLUS_DATA_DIR) + "/recorded/pjlab_crosswalk_a/map.pcd";
  if (!std::filesystem::exists(map)) GTEST_SKIP() << map << " is missing";
  const PointCloud cloud = read_point_cloud(map);
  EXPECT_EQ(cloud.size(), 85546u);
  EXPECT_EQ(cloud.intensities.size(), 85546u);
  EXPECT_TRUE(cloud.origin.isZero());
}

}  // namespace
}  // namespace cpplus
