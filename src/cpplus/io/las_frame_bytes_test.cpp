#include "cpplus/io/las_frame_bytes.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

LasFrame frame_with_records() {
  LasFrame frame;
  frame.scale = {0.001, 0.002, 0.004};
  frame.offset = {600000.0, 5000000.0, -1.5};
  frame.global_encoding = 0x11;
  frame.projection = {{"LASF_Projection", 2112, "WKT", {1, 2, 3}}, {"", 7, "", {}}};
  return frame;
}

TEST(LasFrameBytes, AFrameComesBack) {
  const LasFrame frame = frame_with_records();
  const auto back = parse_las_frame(las_frame_bytes(frame));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->scale, frame.scale);
  EXPECT_EQ(back->offset, frame.offset);
  EXPECT_EQ(back->global_encoding, frame.global_encoding);
  ASSERT_EQ(back->projection.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back->projection[i].user_id, frame.projection[i].user_id);
    EXPECT_EQ(back->projection[i].record_id, frame.projection[i].record_id);
    EXPECT_EQ(back->projection[i].description, frame.projection[i].description);
    EXPECT_EQ(back->projection[i].content, frame.projection[i].content);
  }
}

TEST(LasFrameBytes, WhatIsCutOrGoesOnIsNone) {
  std::vector<uint8_t> bytes = las_frame_bytes(frame_with_records());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(parse_las_frame({bytes.data(), size}).has_value()) << size;
  }
  bytes.push_back(0);
  EXPECT_FALSE(parse_las_frame(bytes).has_value());
}

TEST(LasFrameBytes, ALengthBeyondTheEndReservesNothing) {
  std::vector<uint8_t> bytes = las_frame_bytes(LasFrame());
  for (size_t i = bytes.size() - 4; i < bytes.size(); ++i) bytes[i] = 0xff;  // the number of records
  EXPECT_FALSE(parse_las_frame(bytes).has_value());
}

}  // namespace
}  // namespace cpplus
