#include "cpplus/features/image_gradient.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cpplus {

ImageGradient blurred_gradient(const GrayImage& image, double sigma_px) {
  constexpr double kSobelGain = 8.0;
  constexpr double kBlurGain = ImageGradient::kUnitsPerLevel / kSobelGain;
  const cv::Mat gray(image.height, image.width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
  const int kernel_size = 2 * static_cast<int>(std::ceil(3.0 * sigma_px)) + 1;
  const cv::Mat kernel = cv::getGaussianKernel(kernel_size, sigma_px, CV_32F) * std::sqrt(kBlurGain);
  cv::Mat blurred;
  cv::sepFilter2D(gray, blurred, CV_16S, kernel, kernel);

  ImageGradient gradient;
  gradient.width = image.width;
  gradient.height = image.height;
  gradient.dx.resize(image.pixels.size());
  gradient.dy.resize(image.pixels.size());
  cv::Mat dx(image.height, image.width, CV_16S, gradient.dx.data());
  cv::Mat dy(image.height, image.width, CV_16S, gradient.dy.data());
  cv::Sobel(blurred, dx, CV_16S, 1, 0);
  cv::Sobel(blurred, dy, CV_16S, 0, 1);
  return gradient;
}

}  // namespace cpplus
