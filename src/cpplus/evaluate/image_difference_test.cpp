#include "cpplus/evaluate/image_difference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

TEST(ImageDifference, ByHandOverTheCoveredPixelsOnly) {
  ColorImage photo(3, 1), rendering(3, 1);
  photo.pixels = {{10, 20, 30}, {0, 0, 0}, {255, 0, 0}};
  rendering.pixels = {{13, 20, 26}, {0, 0, 0}, {0, 255, 9}};
  Image<uint8_t> covered(3, 1, 1);
  covered.at(2, 0) = 0;
  const ImageDifference difference = compare_images(photo, rendering, covered);
  EXPECT_EQ(difference.num_pixels, 3u);
  EXPECT_EQ(difference.num_covered, 2u);
  EXPECT_NEAR(difference.mean_square, (9.0 + 0.0 + 16.0) / 6.0, 1e-12);
  EXPECT_NEAR(difference.scale, (130.0 + 400.0 + 780.0) / (169.0 + 400.0 + 676.0), 1e-12);
  EXPECT_LT(difference.matched_mean_square, difference.mean_square);
}

TEST(ImageDifference, AnotherExposureIsMatched) {
  const ColorImage photo(4, 4, Rgb{150, 90, 60}), rendering(4, 4, Rgb{100, 60, 40});
  const ImageDifference difference = compare_images(photo, rendering, Image<uint8_t>(4, 4, 1));
  EXPECT_NEAR(difference.scale, 1.5, 1e-12);
  EXPECT_NEAR(difference.matched_mean_square, 0.0, 1e-9);
  EXPECT_NEAR(difference.mean_square, (2500.0 + 900.0 + 400.0) / 3.0, 1e-9);
}

TEST(ImageDifference, PsnrOfOneLevelAndOfNothing) {
  EXPECT_NEAR(psnr_db(1.0), 48.1308, 1e-4);
  EXPECT_TRUE(std::isinf(psnr_db(0.0)));
}

TEST(ImageDifference, NothingCoveredIsNoDifferenceAndSizesMustAgree) {
  const ColorImage image(2, 2);
  EXPECT_EQ(compare_images(image, image, Image<uint8_t>(2, 2, 0)).num_covered, 0u);
  EXPECT_THROW(compare_images(image, ColorImage(2, 1), Image<uint8_t>(2, 2, 1)), Error);
}

}  // namespace
}  // namespace cpplus
