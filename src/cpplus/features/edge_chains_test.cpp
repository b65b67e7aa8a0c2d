#include "cpplus/features/edge_chains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>

#include "cpplus/core/random.h"

namespace cpplus {
namespace {

// Blocks of random grey and noise: edges of all directions and strengths, corners, and level ground.
GrayImage blocks_and_noise(int width, int height, uint64_t seed) {
  Random random(seed);
  GrayImage image(width, height, 90);
  for (int k = 0; k < 60; ++k) {
    const int x = static_cast<int>(random.below(static_cast<size_t>(width)));
    const int y = static_cast<int>(random.below(static_cast<size_t>(height)));
    const int size = 3 + static_cast<int>(random.below(40));
    const auto gray = static_cast<uint8_t>(random.below(256));
    const bool round = random.below(2) == 0;
    for (int v = std::max(0, y - size); v < std::min(height, y + size); ++v) {
      for (int u = std::max(0, x - size); u < std::min(width, x + size); ++u) {
        if (!round || (u - x) * (u - x) + (v - y) * (v - y) < size * size) image.at(u, v) = gray;
      }
    }
  }
  for (uint8_t& pixel : image.pixels) {
    pixel = static_cast<uint8_t>(std::clamp(pixel + 4.0 * random.normal(), 0.0, 255.0));
  }
  return image;
}

ImageGradient gradient_of(int width, int height) {
  ImageGradient gradient;
  gradient.width = width;
  gradient.height = height;
  gradient.dx.assign(static_cast<size_t>(width * height), 0);
  gradient.dy = gradient.dx;
  return gradient;
}

TEST(EdgeChains, AreThePixelsOfOpenCv) {
  // Widths around whole blocks of eight.
  for (const int width : {1, 7, 8, 161, 200}) {
    for (const uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << width << " " << seed);
      ImageGradient gradient = blurred_gradient(blocks_and_noise(width, 120, seed), 1.2);
      const double weak = 2.0 * ImageGradient::kUnitsPerLevel;
      const double strong = 9.0 * ImageGradient::kUnitsPerLevel;
      const cv::Mat dx(gradient.height, gradient.width, CV_16S, gradient.dx.data());
      const cv::Mat dy(gradient.height, gradient.width, CV_16S, gradient.dy.data());
      cv::Mat expected;
      cv::Canny(dx, dy, expected, weak, strong, true);
      cv::Mat found(gradient.height, gradient.width, CV_8U, cv::Scalar(0));
      for (const EdgePixel& pixel : find_edge_chains(gradient, weak, strong).pixels) {
        found.at<uint8_t>(pixel.y, pixel.x) = 255;
      }
      EXPECT_EQ(cv::countNonZero(expected != found), 0);
      EXPECT_GT(cv::countNonZero(found), width > 100 ? 300 : -1);
    }
  }
}

TEST(EdgeChains, AreTheConnectedSetsWithTheirSizes) {
  ImageGradient gradient = blurred_gradient(blocks_and_noise(200, 120, 4), 1.2);
  const EdgeChains chains =
      find_edge_chains(gradient, 2.0 * ImageGradient::kUnitsPerLevel, 9.0 * ImageGradient::kUnitsPerLevel);
  cv::Mat edges(gradient.height, gradient.width, CV_8U, cv::Scalar(0));
  for (const EdgePixel& pixel : chains.pixels) edges.at<uint8_t>(pixel.y, pixel.x) = 255;
  cv::Mat labels;
  const int num_labels = cv::connectedComponents(edges, labels, 8);
  std::map<uint32_t, int> label_of;
  std::map<uint32_t, uint32_t> count;
  for (const EdgePixel& pixel : chains.pixels) {
    const int label = labels.at<int>(pixel.y, pixel.x);
    EXPECT_EQ(label_of.emplace(pixel.chain, label).first->second, label);
    ++count[pixel.chain];
  }
  EXPECT_EQ(static_cast<int>(label_of.size()), num_labels - 1);  // the background has a label, too
  for (const auto& [chain, size] : count) EXPECT_EQ(chains.sizes[chain], size);
}

TEST(EdgeChains, AWeakPixelCountsBesideAStrongOne) {
  // A column of gradients along the rows: 30, 30, 100, then nothing, then 30.
  ImageGradient gradient = gradient_of(5, 6);
  for (const auto& [y, dx] : std::map<int, int16_t>{{0, 30}, {1, 30}, {2, 100}, {4, 30}}) {
    gradient.dx[gradient.index(2, y)] = dx;
  }
  const EdgeChains chains = find_edge_chains(gradient, 20, 60);
  ASSERT_EQ(chains.pixels.size(), 3);
  for (int y = 0; y < 3; ++y) {
    EXPECT_EQ(chains.pixels[static_cast<size_t>(y)].x, 2);
    EXPECT_EQ(chains.pixels[static_cast<size_t>(y)].y, y);
  }
  EXPECT_EQ(chains.sizes[chains.pixels[0].chain], 3);
  EXPECT_TRUE(find_edge_chains(gradient, 20, 100).pixels.empty());  // none is above the limit
}

}  // namespace
}  // namespace cpplus
