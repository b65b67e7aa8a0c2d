#include "cpplus/report/shrink_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cpplus {

double shrink_factor(int width, int height, int max_side_px) {
  return std::min(1.0, static_cast<double>(max_side_px) / std::max(width, height));
}

ColorImage shrink_image(const ColorImage& image, double factor) {
  ColorImage small(std::max(1, static_cast<int>(std::lround(factor * image.width))),
                   std::max(1, static_cast<int>(std::lround(factor * image.height))));
  const cv::Mat source(image.height, image.width, CV_8UC3, const_cast<Rgb*>(image.pixels.data()));
  cv::Mat target(small.height, small.width, CV_8UC3, small.pixels.data());
  cv::resize(source, target, target.size(), 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace cpplus
