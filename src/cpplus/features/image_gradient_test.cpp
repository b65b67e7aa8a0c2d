#include "cpplus/features/image_gradient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

GrayImage noise(int width, int height) {
  Random random(1);
  GrayImage image(width, height);
  for (uint8_t& pixel : image.pixels) pixel = static_cast<uint8_t>(random.below(256));
  return image;
}

TEST(BlurredGradient, OfARampIsItsSlope) {
  GrayImage image(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) image.at(x, y) = static_cast<uint8_t>(3 * x + 2 * y);
  }
  const ImageGradient gradient = blurred_gradient(image, 1.0);
  for (int y = 5; y < 25; ++y) {
    for (int x = 5; x < 35; ++x) {
      EXPECT_NEAR(gradient.dx[gradient.index(x, y)], 3 * ImageGradient::kUnitsPerLevel, 4);
      EXPECT_NEAR(gradient.dy[gradient.index(x, y)], 2 * ImageGradient::kUnitsPerLevel, 4);
    }
  }
}

TEST(BlurredGradient, IsThatOfOpenCvUpToRounding) {
  for (const auto& [width, height] : {std::pair(64, 48), std::pair(37, 29), std::pair(9, 5), std::pair(3, 1)}) {
    for (const double sigma_px : {0.5, 1.0, 1.5, 3.0}) {
      const GrayImage image = noise(width, height);
      const ImageGradient gradient = blurred_gradient(image, sigma_px);
      const cv::Mat gray(height, width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
      const int size = 2 * static_cast<int>(std::ceil(3.0 * sigma_px)) + 1;
      cv::Mat blurred, dx, dy;
      const cv::Mat kernel = cv::getGaussianKernel(size, sigma_px, CV_64F) * 4.0;
      cv::sepFilter2D(gray, blurred, CV_64F, kernel, kernel);
      cv::Sobel(blurred, dx, CV_64F, 1, 0);
      cv::Sobel(blurred, dy, CV_64F, 0, 1);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          // Each of eight blurred pixels is rounded to a whole number.
          EXPECT_NEAR(gradient.dx[gradient.index(x, y)], dx.at<double>(y, x), 4.01) << width << " " << sigma_px;
          EXPECT_NEAR(gradient.dy[gradient.index(x, y)], dy.at<double>(y, x), 4.01) << width << " " << sigma_px;
        }
      }
    }
  }
}

}  // namespace
}  // namespace cpplus
