#include "cpplus/io/ply.h"

#include <algorithm>

#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using PlyTest = FileTest;

/// The bytes of a number in the byte order.
template <typename T>
std::string number(T value, bool big_endian) {
  std::string bytes = bytes_of(value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

TEST_F(PlyTest, AsciiWithOtherElementsListsAndColors) {
  const PointCloud cloud = read_point_cloud(write("a.ply",
                                                  "ply\nformat ascii 1.0\ncomment made by hand\nelement camera 1\n"
                                                  "property float fov\nelement vertex 2\nproperty uchar red\n"
                                                  "property uchar green\nproperty uchar blue\n"
                                                  "property list uchar int images\nproperty double z\n"
                                                  "property double y\nproperty double x\nelement face 1\n"
                                                  "property list uchar int vertex_indices\nend_header\n"
                                                  "90\n255 128 1 2 7 8 3 2 1\n0 1 2 0 -3 -2 -1\n3 0 1 0\n"));
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.positions[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.positions[1], Eigen::Vector3f(-1, -2, -3));
  EXPECT_THAT(cloud.colors, testing::ElementsAre(Rgb{255, 128, 1}, Rgb{0, 1, 2}));
}

TEST_F(PlyTest, BothByteOrdersWithAndWithoutLists) {
  for (const bool big_endian : {false, true}) {
    for (const bool lists : {false, true}) {
      std::string file = std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
                         " 1.0\nelement box 1\nproperty list uchar short corners\nproperty char kind\n"
                         "element vertex 2\nproperty float x\nproperty short y\n" +
                         (lists ? "property list ushort double seen\n" : "") +
                         "property double z\nproperty ushort scalar_Intensity\nproperty double gps_time\nend_header\n";
      file += '\x02' + number<int16_t>(1, big_endian) + number<int16_t>(2, big_endian) + '\x09';
      for (const int sign : {1, -1}) {
        file +=
            number(1.5f * static_cast<float>(sign), big_endian) + number(static_cast<int16_t>(300 * sign), big_endian);
        if (lists) file += number<uint16_t>(1, big_endian) + number(7.0, big_endian);
        file += number(0.25 * sign, big_endian) + number<uint16_t>(513, big_endian) + number(1e9 + sign, big_endian);
      }
      const PointCloud cloud = read_point_cloud(write("b.ply", file));
      ASSERT_EQ(cloud.size(), 2u);
      EXPECT_EQ(cloud.positions[0], Eigen::Vector3f(1.5f, 300, 0.25f));
      EXPECT_EQ(cloud.positions[1], Eigen::Vector3f(-1.5f, -300, -0.25f));
      EXPECT_THAT(cloud.intensities, testing::ElementsAre(513, 513));
      EXPECT_THAT(cloud.stamps_s, testing::ElementsAre(1e9 + 1, 1e9 - 1));
      for (size_t size = file.find("end_header") + 11; size < file.size(); ++size) {
        EXPECT_ERROR(read_point_cloud(write("cut.ply", file.substr(0, size))), "cut.ply: truncated");
      }
    }
  }
}

TEST_F(PlyTest, ColorsOfFloatingTypeRunToOne) {
  const PointCloud cloud = read_point_cloud(
      write("c.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "property float red\nproperty float green\nproperty float blue\nend_header\n1 2 3 0 0.5 1\n"));
  EXPECT_EQ(cloud.colors.at(0), (Rgb{0, 128, 255}));
}

TEST_F(PlyTest, ColorsNeedAllThreeChannels) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  for (const char* missing : {"red", "green", "blue"}) {
    std::string properties;
    for (const std::string channel : {"red", "green", "blue"}) {
      if (channel != missing) properties += "property uchar " + channel + "\n";
    }
    EXPECT_TRUE(read_point_cloud(write("c.ply", head + properties + "end_header\n1 2 3 4 5\n")).colors.empty());
  }
}

TEST_F(PlyTest, WrittenCloudComesBackExactly) {
  PointCloud cloud;
  cloud.origin = {5000, -7000, 0};
  for (int i = 0; i < 300; ++i) {
    cloud.positions.emplace_back(0.1f * static_cast<float>(i), -1.f / static_cast<float>(i + 1), 3.f);
    cloud.intensities.push_back(0.3f * static_cast<float>(i));
    cloud.colors.push_back({static_cast<uint8_t>(i), static_cast<uint8_t>(i / 3), 255});
    cloud.stamps_s.push_back(1.7e9 + 0.001 * i);
    cloud.num_views.push_back(static_cast<uint16_t>(i % 7));
    cloud.best_images.push_back(4000000000u - static_cast<uint32_t>(i));
    cloud.color_spreads.push_back(static_cast<uint8_t>(i % 251));
  }
  write_point_cloud(path("w.PLY"), cloud);
  const PointCloud back = read_point_cloud(path("w.PLY"));
  ASSERT_EQ(back.size(), cloud.size());
  EXPECT_EQ(back.origin, Eigen::Vector3d(5000, -7001, 0));
  for (size_t i = 0; i < cloud.size(); ++i) ASSERT_LT((back.point(i) - cloud.point(i)).norm(), 1e-7);
  EXPECT_EQ(back.intensities, cloud.intensities);
  EXPECT_EQ(back.colors, cloud.colors);
  EXPECT_EQ(back.stamps_s, cloud.stamps_s);
  EXPECT_EQ(back.num_views, cloud.num_views);
  EXPECT_EQ(back.best_images, cloud.best_images);
  EXPECT_EQ(back.color_spreads, cloud.color_spreads);
}

TEST_F(PlyTest, LyingHeadersAndBrokenFilesAreErrors) {
  const auto expect = [&](const std::string& bytes, const std::string& text) {
    EXPECT_ERROR(read_point_cloud(write("bad.ply", bytes)), text);
    EXPECT_ERROR(read_point_cloud(write("bad.ply", bytes)), path("bad.ply"));
  };
  const std::string xyz = "property float x\nproperty float y\nproperty float z\nend_header\n";
  const std::string ascii = "ply\nformat ascii 1.0\nelement vertex 2\n" + xyz;
  expect("", "does not begin with 'ply'");
  expect("ply\nformat ascii 1.0\n", "no end_header");
  expect("ply\nformat utf8 1.0\nelement vertex 1\n" + xyz + "1 2 3\n", "unknown format 'utf8'");
  expect("ply\nformat ascii 1.0\nelement vertex -1\n" + xyz, "bad.ply:3: bad PLY header line 'element vertex -1'");
  expect("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n", "bad.ply:4: no such PLY type: 'half'");
  expect("ply\nformat ascii 1.0\nelement face 0\nend_header\n", "no element vertex");
  expect("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n", "no x, y and z");
  expect("ply\nformat ascii 1.0\nelement vertex 0\n" + xyz, "holds no points");
  expect("ply\nformat ascii 1.0\nelement vertex 1\nend_header\n1\n", "no x, y and z");
  expect(ascii + "1.5 2.5 3.5\n", "truncated: 1 of 2 lines of element vertex");
  expect(ascii + "1.5 2.5 3.5\n1 2\n", "bad.ply:9: 2 numbers are too few");
  expect(ascii + "1.5 2.5 3.5\n1 2 3 4\n", "bad.ply:9: 4 numbers are too many");
  expect(ascii + "1.5 2.5 3.5\n1 2 z\n", "bad.ply:9: z is not a number: 'z'");
  expect(ascii + "nan 2.5 3.5\n1 2 nan\n", "none of its 2 points is finite");
  expect("ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n" + xyz + std::string(24, 'a'),
         "truncated: element vertex 4000000000 does not fit into the 24 bytes");
}

}  // namespace
}  // namespace cpplus
