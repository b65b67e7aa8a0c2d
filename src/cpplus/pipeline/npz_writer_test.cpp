#include "cpplus/pipeline/npz_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

namespace cpplus {
namespace {

TEST(NpzWriter, HalfPrecisionByHand) {
  EXPECT_EQ(to_half(0.0f), 0x0000);
  EXPECT_EQ(to_half(1.0f), 0x3C00);
  EXPECT_EQ(to_half(-2.0f), 0xC000);
  EXPECT_EQ(to_half(65504.0f), 0x7BFF);
  EXPECT_EQ(to_half(65520.0f), 0x7C00);
  EXPECT_EQ(to_half(std::numeric_limits<float>::infinity()), 0x7C00);
  EXPECT_EQ(to_half(0x1.0p-24f), 0x0001);
  EXPECT_EQ(to_half(0x1.0p-14f), 0x0400);
  EXPECT_EQ(to_half(0.1f), 0x2E66);
  // 1 + 2^-11 lies in the middle of two halves: to the even one; 1 + 3 * 2^-11 likewise goes up.
  EXPECT_EQ(to_half(1.0f + 0x1.0p-11f), 0x3C00);
  EXPECT_EQ(to_half(1.0f + 3.0f * 0x1.0p-11f), 0x3C02);
}

TEST(NpzWriter, ArchiveHoldsTheArraysAtTheirPlaces) {
  const std::string path = (std::filesystem::path(testing::TempDir()) / "npz_writer_test.npz").string();
  write_npz(path, {half_array("range", {1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f}, {2, 3}), int64_scalar("step", 4)});
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_EQ(bytes.substr(0, 4), "PK\x03\x04");
  EXPECT_EQ(bytes.substr(30, 9), "range.npy");
  EXPECT_EQ(bytes.substr(39, 6), "\x93NUMPY");
  EXPECT_NE(bytes.find("'descr': '<f2', 'fortran_order': False, 'shape': (2, 3)"), std::string::npos);
  EXPECT_NE(bytes.find("'descr': '<i8', 'fortran_order': False, 'shape': ()"), std::string::npos);
  // Header of the first array ends on a multiple of 64; then six halves.
  const size_t data = 39 + 128;
  EXPECT_EQ(bytes[data - 1], '\n');
  EXPECT_EQ(static_cast<uint8_t>(bytes[data + 1]), 0x3C);
  EXPECT_EQ(static_cast<uint8_t>(bytes[data + 3]), 0x40);
  EXPECT_EQ(bytes.substr(bytes.size() - 22, 4), "PK\x05\x06");
}

}  // namespace
}  // namespace cpplus
