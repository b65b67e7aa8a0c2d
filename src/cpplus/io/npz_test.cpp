#include "cpplus/io/npz.h"

#include <zlib.h>

#include <cmath>

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using NpzTest = FileTest;

std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
  std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
  header.resize(117, ' ');
  return "\x93NUMPY" + std::string("\x01\x00", 2) + bytes_of<uint16_t>(118) + header + "\n" + data;
}

std::string deflated(const std::string& data) {
  std::string packed(data.size() + 100, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  return packed;
}

/// An archive with an empty first entry and the data as the second.
std::string zip(const std::string& name, const std::string& data, bool deflate) {
  std::string local, directory;
  for (const bool second : {false, true}) {
    const std::string entry = second ? name : "first.npy";
    const std::string content = second ? data : "";
    const std::string packed = second && deflate ? deflated(data) : content;
    const auto checksum = crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()));
    const std::string common =
        bytes_of<uint16_t>(0) + bytes_of<uint16_t>(second && deflate ? 8 : 0) + bytes_of<uint32_t>(0) +
        bytes_of(static_cast<uint32_t>(checksum)) + bytes_of(static_cast<uint32_t>(packed.size())) +
        bytes_of(static_cast<uint32_t>(content.size())) + bytes_of(static_cast<uint16_t>(entry.size()));
    directory += "PK\x01\x02" + bytes_of<uint16_t>(20) + bytes_of<uint16_t>(20) + common + std::string(12, '\0') +
                 bytes_of(static_cast<uint32_t>(local.size())) + entry;
    local += "PK\x03\x04" + bytes_of<uint16_t>(20) + common + bytes_of<uint16_t>(3) + entry + "xyz" + packed;
  }
  return local + directory + "PK\x05\x06" + std::string(4, '\0') + bytes_of<uint16_t>(2) + bytes_of<uint16_t>(2) +
         bytes_of(static_cast<uint32_t>(directory.size())) + bytes_of(static_cast<uint32_t>(local.size())) +
         bytes_of<uint16_t>(0);
}

TEST_F(NpzTest, HalfPrecisionByHand) {
  EXPECT_EQ(half_to_float(0x0000), 0.0f);
  EXPECT_EQ(half_to_float(0x3C00), 1.0f);
  EXPECT_EQ(half_to_float(0xC000), -2.0f);
  EXPECT_EQ(half_to_float(0x3555), 0.333251953125f);
  EXPECT_EQ(half_to_float(0x7BFF), 65504.0f);
  EXPECT_EQ(half_to_float(0x0001), std::ldexp(1.0f, -24));
  EXPECT_EQ(half_to_float(0x0400), std::ldexp(1.0f, -14));
  EXPECT_TRUE(std::isinf(half_to_float(0x7C00)));
  EXPECT_TRUE(std::isnan(half_to_float(0x7E00)));
}

TEST_F(NpzTest, StoredAndDeflatedOfBothTypes) {
  const std::string half = bytes_of<uint16_t>(0x3C00) + bytes_of<uint16_t>(0xC000) + bytes_of<uint16_t>(0) +
                           bytes_of<uint16_t>(0x4000) + bytes_of<uint16_t>(0x4200) + bytes_of<uint16_t>(0x4400);
  const std::string single =
      bytes_of(1.f) + bytes_of(-2.f) + bytes_of(0.f) + bytes_of(2.f) + bytes_of(3.f) + bytes_of(4.f);
  for (const bool deflate : {false, true}) {
    for (const bool is_half : {false, true}) {
      const std::string array = npy(is_half ? "<f2" : "<f4", "(2, 3)", is_half ? half : single);
      const RangeImage image = read_npz_range(write("a.npz", zip("range.npy", array, deflate)));
      EXPECT_EQ(image.width, 3);
      EXPECT_EQ(image.height, 2);
      EXPECT_THAT(image.pixels, testing::ElementsAre(1, -2, 0, 2, 3, 4));
    }
  }
}

TEST_F(NpzTest, DamagedArchivesAndOtherArraysAreErrors) {
  const std::string data(8, '\0');
  const std::string good = zip("range.npy", npy("<f2", "(2, 2)", data), true);
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_ERROR(read_npz_range(write("cut.npz", good.substr(0, size))), "cut.npz: ");
  }
  std::string damaged = good;
  damaged[120] ^= 8;
  EXPECT_ERROR(read_npz_range(write("a.npz", damaged)), "a.npz: array range.npy is damaged");
  EXPECT_ERROR(read_npz_image(write("a.npz", good), "depth"), "a.npz: holds no array depth.npy");
  const auto expect = [&](const std::string& array, const std::string& text) {
    EXPECT_ERROR(read_npz_range(write("a.npz", zip("range.npy", array, false))), "a.npz: array range: " + text);
  };
  expect(npy("<f8", "(2, 2)", data), "its type is '<f8'");
  expect(npy("<f2", "(4,)", data), "its shape is '(4,)'");
  expect(npy("<f2", "(2, 2, 1)", data), "its shape is '(2, 2, 1)'");
  expect(npy("<f2", "(2, 3)", data), "8 bytes for a shape of 2 x 3");
  expect("nothing", "not a NumPy array");
}

TEST(NpzSceneTest, DepthOfASceneIsRead) {
  const std::string path = std::string(CPPLUS_DATA_DIR) + "/truth/office_1/truth/depth/000000.npz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const RangeImage range = read_npz_range(path);
  EXPECT_EQ(range.width, 256);
  EXPECT_EQ(range.height, 192);
  for (const float value : range.pixels) ASSERT_TRUE(value >= 0.0f && value < 200.0f);
}

}  // namespace
}  // namespace cpplus
