#include "cpplus/cloud/plane_buffer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cpplus {
namespace {

// A camera at the map's origin, its axes the map's; two planes: z = 2 in front, and the floor y = 1.5.
class PlaneBufferTest : public testing::Test {
 protected:
  PlaneBufferTest() {
    MapPlane wall, floor;
    wall.normal = {0, 0, -1};
    wall.centroid = {0.3, -0.2, 2.0};
    floor.normal = {0, -1, 0};
    floor.centroid = {0.0, 1.5, 3.0};
    planes_ = {wall, floor};
    buffer_.camera = Camera(CameraModel::kPinhole, 80, 60, {40, 40, 39.5, 29.5});
    buffer_.cell_px = 4.0;
    buffer_.plane = Image<int32_t>(20, 15, PlaneBuffer::kNone);
    buffer_.planes = &planes_;
  }

  void fill(int x0, int x1, int32_t plane) {
    for (int y = 0; y < 15; ++y) {
      for (int x = x0; x < x1; ++x) buffer_.plane.at(x, y) = plane;
    }
  }

  std::vector<MapPlane> planes_;
  PlaneBuffer buffer_;
};

TEST_F(PlaneBufferTest, PlaneAtAPixelIsThatOfItsCell) {
  buffer_.plane.at(3, 2) = 1;
  EXPECT_EQ(buffer_.plane_at({11.5, 7.5}), 1);  // cell 3 spans the pixels 12 to 15, from 11.5 to 15.5
  EXPECT_EQ(buffer_.plane_at({15.4, 11.4}), 1);
  EXPECT_EQ(buffer_.plane_at({11.4, 9.0}), PlaneBuffer::kNone);
  EXPECT_EQ(buffer_.plane_at({-3.0, 9.0}), PlaneBuffer::kNone);
  EXPECT_EQ(buffer_.plane_at({14.0, 600.0}), PlaneBuffer::kNone);
}

TEST_F(PlaneBufferTest, RangeIsAlongTheBearing) {
  EXPECT_NEAR(buffer_.range_of(planes_[0], {39.5, 29.5}), 2.0, 1e-12);
  // 40 px right of the middle = 45 degrees: 2 sqrt(2).
  EXPECT_NEAR(buffer_.range_of(planes_[0], {79.5, 29.5}), 2.0 * std::sqrt(2.0), 1e-9);
  // 30 px down of 40: tan = 3/4, the floor 1.5 m below is met at 1.5 / (3/5) = 2.5 m.
  EXPECT_NEAR(buffer_.range_of(planes_[1], {39.5, 59.5}), 2.5, 1e-9);
}

TEST_F(PlaneBufferTest, APlaneThatIsNotMetHasNoRange) {
  EXPECT_TRUE(std::isnan(buffer_.range_of(planes_[1], {39.5, 10.0})));  // the ray rises
  EXPECT_TRUE(std::isnan(buffer_.range_of(planes_[1], {39.5, 29.5})));  // parallel to the floor
}

TEST_F(PlaneBufferTest, AWallHidesWhatIsFartherThanTheMargin) {
  fill(0, 20, 0);
  EXPECT_TRUE(buffer_.is_visible({0, 0, 1.0}, {39.5, 29.5}, 0.04));
  EXPECT_TRUE(buffer_.is_visible({0, 0, 2.03}, {39.5, 29.5}, 0.04));
  EXPECT_FALSE(buffer_.is_visible({0, 0, 2.06}, {39.5, 29.5}, 0.04));
  EXPECT_FALSE(buffer_.is_visible({0, 0, 9.0}, {39.5, 29.5}, 0.04));
}

TEST_F(PlaneBufferTest, ACellBesideThatIsFreeLetsThePointBeSeen) {
  fill(0, 10, 0);
  // Cell 10 begins at pixel 39.5: from cell 9 the point may peek out, from cell 8 not.
  EXPECT_TRUE(buffer_.is_visible({0, 0, 5.0}, {37.0, 29.5}, 0.04));
  EXPECT_FALSE(buffer_.is_visible({0, 0, 5.0}, {33.0, 29.5}, 0.04));
}

}  // namespace
}  // namespace cpplus
