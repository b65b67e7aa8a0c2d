#include "cpplus/io/pnts.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

namespace cpplus {
namespace {

template <typename Number>
Number read(const std::string& bytes, size_t offset) {
  Number value;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

TEST(Pnts, HoldsWhatTheFormatAsksFor) {
  const std::vector<Eigen::Vector3d> positions = {{10, -4, 2}, {12, 0, 2}, {11, -1, 2}};
  const std::vector<Rgb> colors = {{255, 0, 1}, {0, 255, 2}, {7, 8, 9}};
  const std::string bytes = encode_pnts(positions, colors);
  EXPECT_EQ(bytes.substr(0, 4), "pnts");
  EXPECT_EQ(read<uint32_t>(bytes, 4), 1u);
  EXPECT_EQ(read<uint32_t>(bytes, 8), bytes.size());
  const size_t json_size = read<uint32_t>(bytes, 12);
  const size_t binary_size = read<uint32_t>(bytes, 16);
  EXPECT_EQ(28 + json_size + binary_size, bytes.size());
  EXPECT_EQ((28 + json_size) % 8, 0u);
  EXPECT_EQ(bytes.size() % 8, 0u);

  const auto table = nlohmann::json::parse(bytes.substr(28, json_size));
  EXPECT_EQ(table["POINTS_LENGTH"], 3);
  EXPECT_EQ(table["QUANTIZED_VOLUME_OFFSET"], nlohmann::json({10.0, -4.0, 2.0}));
  const size_t binary = 28 + json_size;
  for (size_t i = 0; i < positions.size(); ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const double steps = read<uint16_t>(bytes, binary + 2 * (3 * i + axis));
      const double extent = table["QUANTIZED_VOLUME_SCALE"][axis], offset = table["QUANTIZED_VOLUME_OFFSET"][axis];
      EXPECT_NEAR(offset + extent * steps / 65535.0, positions[i][static_cast<Eigen::Index>(axis)], extent / 65535.0);
      EXPECT_EQ(static_cast<uint8_t>(bytes[binary + table["RGB"]["byteOffset"].get<size_t>() + 3 * i + axis]),
                colors[i][axis]);
    }
  }
}

}  // namespace
}  // namespace cpplus
