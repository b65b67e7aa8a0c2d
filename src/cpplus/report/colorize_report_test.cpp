#include "cpplus/report/colorize_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace cpplus {
namespace {

HeldOutImage held_out(const char* name, size_t num_covered, double mean_square, bool blurred) {
  HeldOutImage image;
  image.name = name;
  image.difference.num_pixels = 1000;
  image.difference.num_covered = num_covered;
  image.difference.mean_square = image.difference.matched_mean_square = mean_square;
  image.blurred = blurred;
  return image;
}

TEST(HeldOutImages, CountByTheirPixelsAndNotWhereBlurred) {
  const ImageDifference total = total_difference(
      {held_out("a", 100, 4.0, false), held_out("b", 300, 8.0, false), held_out("c", 900, 500.0, true)});
  EXPECT_EQ(total.num_pixels, 2000u);
  EXPECT_EQ(total.num_covered, 400u);
  EXPECT_DOUBLE_EQ(total.mean_square, 7.0);
}

TEST(HeldOutImages, AreAllInTheReport) {
  const auto report = nlohmann::json::parse(
      colorize_report_json({}, {held_out("a", 100, 4.0, false), held_out("c", 900, 500.0, true)}));
  ASSERT_EQ(report["held_out"]["images"].size(), 2u);
  EXPECT_EQ(report["held_out"]["images"][0]["blurred"], false);
  EXPECT_EQ(report["held_out"]["images"][1]["blurred"], true);
  EXPECT_NEAR(report["held_out"]["psnr_db"].get<double>(), psnr_db(4.0), 1e-9);
}

TEST(HeldOutImages, WithoutASharpOneThereIsNoFigure) {
  const auto report = nlohmann::json::parse(colorize_report_json({}, {held_out("c", 900, 500.0, true)}));
  EXPECT_TRUE(report["held_out"]["psnr_db"].is_null());
}

}  // namespace
}  // namespace cpplus
