#include "cpplus/io/las.h"

#include <cmath>
#include <cstring>

#include "cpplus/io/las_header.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using LasTest = FileTest;

template <typename T>
void patch(std::string* bytes, size_t offset, T value) {
  std::memcpy(bytes->data() + offset, &value, sizeof(T));
}

constexpr size_t kHeaderSizes[] = {227, 235, 375};

/// Two points near Munich in UTM, on a grid of 1 mm, made after the specification and not with the writer.
std::string utm_file(int version_minor, int point_format, size_t extra_bytes = 0) {
  const size_t header_size = kHeaderSizes[version_minor - 2];
  const size_t record_size = las_record_size(point_format) + extra_bytes;
  std::string file(header_size + 54 + 5 + 2, '\0');  // a record of 5 bytes, and 2 bytes of nothing before the points
  file.replace(0, 4, "LASF");
  patch<uint16_t>(&file, 6, 0x11);
  patch<uint8_t>(&file, 24, 1);
  patch<uint8_t>(&file, 25, static_cast<uint8_t>(version_minor));
  patch<uint16_t>(&file, 94, static_cast<uint16_t>(header_size));
  patch<uint32_t>(&file, 96, static_cast<uint32_t>(file.size()));
  patch<uint32_t>(&file, 100, 1);
  patch<uint8_t>(&file, 104, static_cast<uint8_t>(point_format));
  patch<uint16_t>(&file, 105, static_cast<uint16_t>(record_size));
  if (point_format < 6) patch<uint32_t>(&file, 107, 2);
  if (version_minor == 4) patch<uint64_t>(&file, 247, 2);
  for (size_t axis = 0; axis < 3; ++axis) patch<double>(&file, 131 + 8 * axis, 0.001);
  patch<double>(&file, 155, 600000);
  patch<double>(&file, 163, 5000000);
  file.replace(header_size + 2, 15, "LASF_Projection");
  patch<uint16_t>(&file, header_size + 18, 2112);
  patch<uint16_t>(&file, header_size + 20, 5);
  file.replace(header_size + 54, 5, "WKT!!");
  for (int i = 0; i < 2; ++i) {
    std::string record(record_size, '\0');
    patch<int32_t>(&record, 0, 91234567 + i);
    patch<int32_t>(&record, 4, 334567891 - 7000000 * i);
    patch<int32_t>(&record, 8, -12345 * i);
    patch<uint16_t>(&record, 12, static_cast<uint16_t>(1000 + i));
    if (las_stamp_offset(point_format) > 0) patch<double>(&record, las_stamp_offset(point_format), 3e8 + 0.25 * i);
    if (las_color_offset(point_format) > 0) {
      patch<uint16_t>(&record, las_color_offset(point_format), 0xFF12);
      patch<uint16_t>(&record, las_color_offset(point_format) + 2, 0x8034);
      patch<uint16_t>(&record, las_color_offset(point_format) + 4, static_cast<uint16_t>(0x0100 * i));
    }
    file += record;
  }
  return file;
}

TEST_F(LasTest, AllVersionsAndFormats) {
  for (const int version_minor : {2, 3, 4}) {
    for (const int point_format : {0, 1, 2, 3, 6, 7, 8}) {
      if (point_format > 3 && version_minor < 4) continue;
      for (const size_t extra_bytes : {0, 5}) {
        const PointCloud cloud = read_point_cloud(write("a.las", utm_file(version_minor, point_format, extra_bytes)));
        ASSERT_EQ(cloud.size(), 2u);
        EXPECT_EQ(cloud.origin, Eigen::Vector3d(691235, 5334568, 0));
        EXPECT_LT((cloud.point(0) - Eigen::Vector3d(691234.567, 5334567.891, 0)).norm(), 1e-7);
        EXPECT_LT((cloud.point(1) - Eigen::Vector3d(691234.568, 5327567.891, -12.345)).norm(), 3e-4);
        EXPECT_THAT(cloud.intensities, testing::ElementsAre(1000, 1001));
        const bool has_stamps = point_format == 1 || point_format == 3 || point_format >= 6;
        const bool has_colors = point_format == 2 || point_format == 3 || point_format >= 7;
        ASSERT_EQ(cloud.stamps_s.size(), has_stamps ? 2u : 0u);
        if (has_stamps) {
          EXPECT_EQ(cloud.stamps_s[1], 3e8 + 0.25);
        }
        ASSERT_EQ(cloud.colors.size(), has_colors ? 2u : 0u);
        if (has_colors) {
          EXPECT_EQ(cloud.colors[1], (Rgb{255, 128, 1}));
        }
        ASSERT_TRUE(cloud.las_frame.has_value());
        EXPECT_EQ(cloud.las_frame->scale, Eigen::Vector3d(0.001, 0.001, 0.001));
        EXPECT_EQ(cloud.las_frame->offset, Eigen::Vector3d(600000, 5000000, 0));
      }
    }
  }
}

TEST_F(LasTest, RoundTripKeepsIntegersGridAndCoordinateSystem) {
  const std::string file = utm_file(2, 3);
  const PointCloud cloud = read_point_cloud(write("a.las", file));
  write_point_cloud(path("b.las"), cloud);
  const std::string back = read("b.las");
  BlockReader reader(path("b.las"));
  const LasHeader header = read_las_header(&reader);
  EXPECT_EQ(header.point_format, 7) << "WKT asks for one of the newer formats";
  EXPECT_EQ(header.num_points, 2u);
  EXPECT_EQ(header.frame.scale, cloud.las_frame->scale);
  EXPECT_EQ(header.frame.offset, cloud.las_frame->offset);
  EXPECT_EQ(header.frame.global_encoding, 0x11);
  ASSERT_EQ(header.frame.projection.size(), 1u);
  EXPECT_EQ(header.frame.projection[0].record_id, 2112);
  EXPECT_EQ(header.frame.projection[0].content, (std::vector<uint8_t>{'W', 'K', 'T', '!', '!'}));
  EXPECT_NEAR(header.min.y(), 5327567.891, 1e-8);
  EXPECT_NEAR(header.max.y(), 5334567.891, 1e-8);
  EXPECT_NEAR(header.min.z(), -12.345, 1e-8);
  // X, Y, Z as integers: 7 km apart and still the same. The first 14 bytes of a record also hold the intensity.
  for (const size_t i : {0, 1}) {
    EXPECT_EQ(back.substr(reader.position() + 36 * i, 14), file.substr(227 + 61 + 34 * i, 14)) << i;
    EXPECT_EQ(back.substr(reader.position() + 36 * i + 22, 8), file.substr(227 + 61 + 34 * i + 20, 8)) << i;
  }
}

TEST_F(LasTest, IntegersSurviveAcrossEightKilometres) {
  PointCloud cloud;
  cloud.origin = {691235, 5334568, 0};
  cloud.las_frame = LasFrame();
  cloud.las_frame->offset = {691000, 5334000, 0};
  std::vector<int32_t> integers;
  for (int i = 0; i < 5000; ++i) {
    integers.push_back(235000 + 1677 * i);  // up to 8.4 km from the origin in steps of 1 mm
    cloud.positions.emplace_back(static_cast<float>(0.001 * integers.back() - 235), 0.f, 0.f);
  }
  write_point_cloud(path("a.las"), cloud);
  const PointCloud back = read_point_cloud(path("a.las"));
  for (size_t i = 0; i < integers.size(); ++i) {
    ASSERT_EQ(std::lround((back.point(i).x() - 691000) / 0.001), integers[i]) << i;
  }
}

TEST_F(LasTest, CloudWithoutFrameComesBackWithinATenthOfAMillimetre) {
  PointCloud cloud;
  for (int i = 0; i < 300; ++i) {
    cloud.positions.emplace_back(0.1f * static_cast<float>(i), -100.f / static_cast<float>(i + 1), 3.f);
    cloud.intensities.push_back(static_cast<float>(i) / 300.f);
    cloud.colors.push_back({static_cast<uint8_t>(i), static_cast<uint8_t>(i / 3), 255});
    cloud.stamps_s.push_back(1.7e9 + 0.001 * i);
    cloud.num_views.push_back(static_cast<uint16_t>(i % 7));
    cloud.best_images.push_back(4000000000u - static_cast<uint32_t>(i));
    cloud.color_spreads.push_back(static_cast<uint8_t>(i % 251));
  }
  write_point_cloud(path("a.las"), cloud);
  const PointCloud back = read_point_cloud(path("a.las"));
  ASSERT_EQ(back.size(), cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_LT((back.point(i) - cloud.point(i)).cwiseAbs().maxCoeff(), 0.51e-4) << i;
    ASSERT_NEAR(back.intensities[i], 65535.0 * static_cast<double>(cloud.intensities[i]), 0.51) << i;
  }
  EXPECT_EQ(back.colors, cloud.colors);
  EXPECT_EQ(back.stamps_s, cloud.stamps_s);
  EXPECT_EQ(back.num_views, cloud.num_views);
  EXPECT_EQ(back.best_images, cloud.best_images);
  EXPECT_EQ(back.color_spreads, cloud.color_spreads);
}

TEST_F(LasTest, TheNewerFormatsGiveBackColoursAndExtraBytes) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {4, 5, 6}};
  cloud.colors = {{1, 2, 3}, {250, 251, 252}};
  cloud.num_views = {0, 300};
  cloud.best_images = {0, 70000};
  cloud.color_spreads = {0, 17};
  cloud.las_frame.emplace();
  for (const uint16_t encoding : {0x00, 0x10}) {
    cloud.las_frame->global_encoding = encoding;
    write_point_cloud(path("a.las"), cloud);
    BlockReader reader(path("a.las"));
    EXPECT_EQ(read_las_header(&reader).point_format, encoding == 0 ? 2 : 7);
    const PointCloud back = read_point_cloud(path("a.las"));
    EXPECT_EQ(back.colors, cloud.colors);
    EXPECT_EQ(back.num_views, cloud.num_views);
    EXPECT_EQ(back.best_images, cloud.best_images);
    EXPECT_EQ(back.color_spreads, cloud.color_spreads);
  }
}

TEST_F(LasTest, ColorsOfEightBitsStayAsTheyAre) {
  std::string file = utm_file(2, 2);
  for (const size_t i : {0, 1}) {
    for (const size_t channel : {0, 1, 2}) {
      patch<uint16_t>(&file, 227 + 61 + 26 * i + 20 + 2 * channel, static_cast<uint16_t>(100 * i + 10 * channel));
    }
  }
  EXPECT_THAT(read_point_cloud(write("a.las", file)).colors, testing::ElementsAre(Rgb{0, 10, 20}, Rgb{100, 110, 120}));
  // One large value shows that the file has 16 bits, also for the points before it.
  patch<uint16_t>(&file, 227 + 61 + 26 + 20, 0x2000);
  EXPECT_THAT(read_point_cloud(write("a.las", file)).colors, testing::ElementsAre(Rgb{0, 0, 0}, Rgb{0x20, 0, 0}));
}

TEST_F(LasTest, CloudTooLargeForTheGridMovesTheOffsetOrFails) {
  PointCloud cloud;
  cloud.origin = {691235, 5334568, 0};
  cloud.positions = {Eigen::Vector3f(1, 2, 3)};
  cloud.las_frame = LasFrame();
  cloud.las_frame->scale.setConstant(1e-5);  // reaches 21 km from an offset of zero
  write_point_cloud(path("a.las"), cloud);
  EXPECT_LT((read_point_cloud(path("a.las")).point(0) - cloud.point(0)).norm(), 1e-5);
  cloud.positions.emplace_back(50000.f, 0.f, 0.f);
  EXPECT_ERROR(write_point_cloud(path("b.las"), cloud), "b.las: an extent of 49999 m does not fit");
  EXPECT_EQ(num_files(), 1u);
}

TEST_F(LasTest, LyingHeadersAndBrokenFilesAreErrors) {
  const auto expect = [&](const std::string& bytes, const std::string& text) {
    EXPECT_ERROR(read_point_cloud(write("bad.las", bytes)), text);
    EXPECT_ERROR(read_point_cloud(write("bad.las", bytes)), path("bad.las"));
  };
  const std::string good = utm_file(4, 7);
  const auto with = [&](size_t offset, auto value) {
    std::string bytes = good;
    patch(&bytes, offset, value);
    return bytes;
  };
  expect("", "truncated: 0 bytes are too few");
  expect(good.substr(0, 226), "truncated: 226 bytes are too few");
  for (size_t size = 227; size < good.size(); ++size) {
    EXPECT_ERROR(read_point_cloud(write("cut.las", good.substr(0, size))), "cut.las: ");
  }
  expect(with(0, 'X'), "no LASF at its start");
  expect(with(25, uint8_t{1}), "version 1.1 is not supported");
  expect(with(24, uint8_t{2}), "version 2.4 is not supported");
  expect(with(94, uint16_t{227}), "header size 227 is less than the 375 of version 1.4");
  expect(with(96, uint32_t{300}), "points at offset 300 with a header of 375");
  expect(with(96, uint32_t{1u << 31}), "points at offset 2147483648");
  expect(with(104, uint8_t{9}), "point format 9 is not supported");
  expect(with(104, uint8_t{0x80 | 7}), "LAZ-compressed");
  expect(with(105, uint16_t{35}), "records of 35 bytes are too short for point format 7 (36 bytes)");
  expect(with(247, uint64_t{1} << 60), "truncated: 1152921504606846976 points");
  expect(with(247, uint64_t{3}), "truncated: 3 points of 36 bytes do not fit");
  expect(with(247, uint64_t{0}), "holds no points");
  expect(with(131, 0.0), "x scale 0 is not positive");
  expect(with(139, -0.01), "y scale -0.01 is not positive");
  expect(with(171, std::nan("")), "z offset nan is not finite");
  expect(with(100, uint32_t{1000}), "1000 variable length records do not fit");
  expect(with(375 + 20, uint16_t{9000}), "variable length record 0 of 9000 bytes runs into the points");
}

}  // namespace
}  // namespace cpplus
