#include "cpplus/report/display_colors.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(DisplayColors, PointsThatNoImageSeesAreGreyByIntensity) {
  PointCloud cloud;
  cloud.positions.resize(4);
  cloud.colors = {{10, 20, 30}, {1, 1, 1}, {40, 50, 60}, {0, 0, 0}};
  cloud.num_views = {1, 0, 2, 0};
  cloud.intensities = {0.0f, 0.0f, 5.0f, 5.0f};
  const DisplayColors shown = display_colors(cloud);
  EXPECT_EQ(shown.colors, (std::vector<Rgb>{{10, 20, 30}, {60, 60, 60}, {40, 50, 60}, {190, 190, 190}}));
  EXPECT_EQ(shown.is_colored, (std::vector<uint8_t>{1, 0, 1, 0}));
}

TEST(DisplayColors, CloudWithoutColorAndIntensityIsOneGrey) {
  PointCloud cloud;
  cloud.positions.resize(2);
  EXPECT_EQ(display_colors(cloud).colors, (std::vector<Rgb>{{130, 130, 130}, {130, 130, 130}}));
}

TEST(DisplayColors, ColorsWithoutViewCountsStay) {
  PointCloud cloud;
  cloud.positions.resize(1);
  cloud.colors = {{0, 0, 0}};
  EXPECT_EQ(display_colors(cloud).colors, cloud.colors);
}

}  // namespace
}  // namespace cpplus
