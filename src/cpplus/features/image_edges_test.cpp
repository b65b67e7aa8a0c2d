#include "cpplus/features/image_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Field = std::function<double(double x, double y)>;

/// Each pixel is the mean of the field over its square (8 x 8 samples), plus noise, rounded.
GrayImage render(int width, int height, const Field& field, double noise = 0.0, uint64_t seed = 1) {
  constexpr int kSamples = 8;
  Random random(seed);
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        sum += field(x + (i % kSamples + 0.5) / kSamples - 0.5, y + (i / kSamples + 0.5) / kSamples - 0.5);
      }
      const double value = sum / (kSamples * kSamples) + (noise > 0.0 ? noise * random.normal() : 0.0);
      image.at(x, y) = static_cast<uint8_t>(std::clamp(std::round(value), 0.0, 255.0));
    }
  }
  return image;
}

GrayImage through_jpeg(const GrayImage& image, int quality) {
  const cv::Mat gray(image.height, image.width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", gray, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  const cv::Mat decoded = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  GrayImage result(image.width, image.height);
  std::copy(decoded.begin<uint8_t>(), decoded.end<uint8_t>(), result.pixels.begin());
  return result;
}

/// From `dark` to dark + contrast across the line normal . (x - point) = 0, blurred by a Gaussian.
Field step(const Eigen::Vector2d& point, double angle, double blur_px, double dark, double contrast) {
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  return [=](double x, double y) {
    const double distance = normal.dot(Eigen::Vector2d(x, y) - point);
    return dark + contrast * 0.5 * (1.0 + std::erf(distance / (blur_px * std::sqrt(2.0))));
  };
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

double angle_deg(const Eigen::Vector2f& a, const Eigen::Vector2d& b) {
  return std::acos(std::clamp(a.cast<double>().dot(b), -1.0, 1.0)) * 180.0 / M_PI;
}

// ---- by hand ----

TEST(ImageEdges, VerticalStepLiesWhereItsPixelIsDivided) {
  for (const double share : {0.0, 0.25, 0.5, 0.75}) {
    GrayImage image(40, 40, 50);
    for (int y = 0; y < 40; ++y) {
      image.at(20, y) = static_cast<uint8_t>(50 + 100 * share);  // its right part, `share` of it, is bright
      for (int x = 21; x < 40; ++x) image.at(x, y) = 150;
    }
    const ImageEdges edges = detect_image_edges(image, {});
    EXPECT_EQ(edges.width, 40);
    EXPECT_EQ(edges.height, 40);
    ASSERT_EQ(edges.edgels.size(), 40 - 2 * 3);  // one a row outside the margin
    for (const ImageEdgel& edgel : edges.edgels) {
      EXPECT_NEAR(edgel.pixel.x(), 20.5 - share, 0.04);
      EXPECT_TRUE(edgel.normal.isApprox(Eigen::Vector2f(1, 0), 1e-3f));
    }
  }
}

TEST(ImageEdges, GradientIsInGreyLevelsPerPixel) {
  GrayImage image(40, 40, 50);  // a step of 100 at the centre of column 20
  for (int y = 0; y < 40; ++y) {
    image.at(20, y) = 100;
    for (int x = 21; x < 40; ++x) image.at(x, y) = 150;
  }
  // Blurred by a unit Gaussian, the step rises from column 19 to 21 by 100 (Phi(1) - Phi(-1)) = 68, a little less since
  // column 20 is a mixture.
  const ImageEdges edges = detect_image_edges(image, {});
  ASSERT_FALSE(edges.edgels.empty());
  for (const ImageEdgel& edgel : edges.edgels) EXPECT_NEAR(edgel.gradient, 33.0, 1.0);
}

// ---- rendered steps: all angles and offsets ----

struct StepCase {
  const char* name;
  double blur_px, contrast, noise;
  int jpeg_quality;  // 0 = not compressed
  double max_median_px, max_bias_px, max_angle_deg;
};

std::ostream& operator<<(std::ostream& out, const StepCase& c) { return out << c.name; }

class ImageEdgesOfSteps : public ::testing::TestWithParam<StepCase> {};

TEST_P(ImageEdgesOfSteps, PositionAndDirection) {
  const StepCase& c = GetParam();
  constexpr int kSize = 64;
  Random random(5);
  std::vector<double> errors;
  std::vector<double> angles;
  double sum = 0.0;
  int lines = 0;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2.0 * M_PI * (i + random.uniform()) / 60.0;
    const Eigen::Vector2d point(31.5 + random.uniform(-4, 4), 31.5 + random.uniform(-4, 4));
    GrayImage image = render(kSize, kSize, step(point, angle, c.blur_px, 120 - c.contrast / 2, c.contrast), c.noise, i);
    if (c.jpeg_quality > 0) image = through_jpeg(image, c.jpeg_quality);
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    int found = 0;
    for (const ImageEdgel& edgel : detect_image_edges(image, {}).edgels) {
      const double error = normal.dot(edgel.pixel.cast<double>() - point);
      if (std::abs(error) > 3.0) continue;  // noise elsewhere: another test counts it
      ++found;
      errors.push_back(std::abs(error));
      angles.push_back(angle_deg(edgel.normal, normal));
      sum += error;
    }
    if (found >= 45) ++lines;
  }
  EXPECT_EQ(lines, 60) << "lines found over at least 45 of their ~58 pixels";
  EXPECT_LE(median(errors), c.max_median_px);
  EXPECT_LE(std::abs(sum / static_cast<double>(errors.size())), c.max_bias_px);
  EXPECT_LE(median(angles), c.max_angle_deg);
}

INSTANTIATE_TEST_SUITE_P(Quality, ImageEdgesOfSteps,
                         ::testing::Values(StepCase{"sharp", 0.5, 100, 0, 0, 0.01, 0.005, 0.6},
                                           StepCase{"medium", 1.0, 100, 0, 0, 0.01, 0.005, 0.6},
                                           StepCase{"soft", 1.5, 100, 0, 0, 0.015, 0.005, 0.6},
                                           StepCase{"faint", 1.0, 10, 0, 0, 0.04, 0.01, 1.5},
                                           StepCase{"sharp_noise_jpeg", 0.5, 100, 3, 90, 0.03, 0.02, 1.0},
                                           StepCase{"medium_noise_jpeg", 1.0, 40, 3, 85, 0.1, 0.02, 2.5},
                                           StepCase{"soft_noise_jpeg", 1.5, 40, 3, 85, 0.15, 0.03, 3.0},
                                           StepCase{"faint_noise_jpeg", 0.7, 20, 2, 90, 0.15, 0.03, 3.5}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ImageEdges, CircleIsClosedWithNormalsTowardsTheBrightSide) {
  const Eigen::Vector2d center(50.3, 49.6);
  constexpr double kRadius = 30.0;
  const GrayImage image = render(101, 101, [&](double x, double y) {
    return 60 + 90 * 0.5 * (1 + std::erf((kRadius - (Eigen::Vector2d(x, y) - center).norm()) / std::sqrt(2.0)));
  });
  std::vector<bool> sectors(90, false);
  double sum = 0.0;
  const ImageEdges edges = detect_image_edges(image, {});
  for (const ImageEdgel& edgel : edges.edgels) {
    const Eigen::Vector2d offset = edgel.pixel.cast<double>() - center;
    EXPECT_NEAR(offset.norm(), kRadius, 0.15);
    EXPECT_LT(angle_deg(edgel.normal, -offset.normalized()), 3.0);
    sum += offset.norm() - kRadius;
    sectors[static_cast<size_t>((std::atan2(offset.y(), offset.x()) + M_PI) / (2 * M_PI) * 89.999)] = true;
  }
  EXPECT_EQ(std::count(sectors.begin(), sectors.end(), true), 90);
  EXPECT_LT(std::abs(sum / static_cast<double>(edges.edgels.size())), 0.05);  // a blurred circle shrinks a little
}

// ---- borders, specks, noise, contrast ----

TEST(ImageEdges, NothingAtTheBorderAndNoBiasNextToIt) {
  const Eigen::Vector2d point(40, 30);
  for (const double angle : {0.3, 1.1, 1.9, 2.6}) {
    const GrayImage image = render(80, 60, step(point, angle, 0.7, 60, 100));
    const ImageEdges edges = detect_image_edges(image, {});
    EXPECT_GT(edges.edgels.size(), 45u);
    for (const ImageEdgel& edgel : edges.edgels) {
      EXPECT_LT(std::abs(Eigen::Vector2d(std::cos(angle), std::sin(angle)).dot(edgel.pixel.cast<double>() - point)),
                0.06)
          << edgel.pixel.transpose();
      EXPECT_GE(std::min(edgel.pixel.x(), edgel.pixel.y()), 2.0f);
    }
  }
  // A ramp that ends at the border is no edge.
  EXPECT_TRUE(detect_image_edges(render(80, 60, [](double x, double) { return 20 + 2 * x; }), {}).edgels.empty());
}

TEST(ImageEdges, SpecksAreDropped) {
  GrayImage image(60, 60, 80);
  for (int y = 10; y < 60; y += 15) {
    for (int x = 10; x < 60; x += 15) image.at(x, y) = image.at(x + 1, y) = 200;
  }
  ImageEdgeOptions options;
  options.min_chain_px = 1;
  EXPECT_GT(detect_image_edges(image, options).edgels.size(), 40u);
  options.min_chain_px = 20;
  EXPECT_TRUE(detect_image_edges(image, options).edgels.empty());
}

TEST(ImageEdges, NoiseAloneGivesAlmostNothing) {
  for (const double noise : {0.0, 1.0, 3.0, 8.0}) {
    const GrayImage image = render(
        200, 200, [](double, double) { return 50.0; }, noise);
    EXPECT_LE(detect_image_edges(image, {}).edgels.size(), 40u) << noise;  // 0.1 %
  }
}

TEST(ImageEdges, ThresholdFollowsADarkImage) {
  // A wall's corner of 5 grey levels at brightness 12, as in an unlit corridor.
  const Eigen::Vector2d point(100, 100);
  const GrayImage image = render(200, 200, step(point, 0.4, 0.8, 12, 5), 0.6);
  int on_line = 0;
  int elsewhere = 0;
  for (const ImageEdgel& edgel : detect_image_edges(image, {}).edgels) {
    const double error = Eigen::Vector2d(std::cos(0.4), std::sin(0.4)).dot(edgel.pixel.cast<double>() - point);
    ++(std::abs(error) < 1.0 ? on_line : elsewhere);
  }
  EXPECT_GT(on_line, 150);
  EXPECT_LT(elsewhere, 20);
}

// ---- determinism, bad input ----

TEST(ImageEdges, SameForAnyNumberOfThreadsAndInRowMajorOrder) {
  const GrayImage image = render(
      300, 200, [](double x, double y) { return 128 + 60 * std::sin(x / 5.0) * std::cos(y / 7.0 + x / 40.0); }, 2.0);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const ImageEdges one = detect_image_edges(image, {});
  cv::setNumThreads(4);
  const ImageEdges four = detect_image_edges(image, {});
  cv::setNumThreads(threads);
  ASSERT_GT(one.edgels.size(), 1000u);
  ASSERT_EQ(one.edgels.size(), four.edgels.size());
  for (size_t i = 0; i < one.edgels.size(); ++i) {
    EXPECT_EQ(one.edgels[i].pixel, four.edgels[i].pixel);
    EXPECT_EQ(one.edgels[i].normal, four.edgels[i].normal);
    EXPECT_NEAR(one.edgels[i].normal.norm(), 1.0f, 1e-5f);
    if (i > 0) {
      EXPECT_GT(one.edgels[i].pixel.y(), one.edgels[i - 1].pixel.y() - 2.0f);
    }
  }
}

TEST(ImageEdges, EmptyAndTinyImagesHaveNone) {
  EXPECT_TRUE(detect_image_edges(GrayImage(), {}).edgels.empty());
  EXPECT_TRUE(detect_image_edges(GrayImage(1, 1, 7), {}).edgels.empty());
  EXPECT_TRUE(detect_image_edges(GrayImage(6, 200, 7), {}).edgels.empty());
  EXPECT_TRUE(detect_image_edges(GrayImage(7, 7, 7), {}).edgels.empty());
}

TEST(ImageEdges, OptionsOutOfRangeAreRefused) {
  const auto refused = [](const std::function<void(ImageEdgeOptions*)>& change) {
    ImageEdgeOptions options;
    change(&options);
    try {
      detect_image_edges(GrayImage(20, 20), options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused([](ImageEdgeOptions* o) { o->sigma_px = 0; }), "option sigma_px must be in [0.5, 5], got 0");
  EXPECT_NE(refused([](ImageEdgeOptions* o) { o->strong_quantile = 1; }), "");
  EXPECT_NE(refused([](ImageEdgeOptions* o) { o->noise_ratio = -1; }), "");
  EXPECT_NE(refused([](ImageEdgeOptions* o) { o->min_gradient = std::nan(""); }), "");
  EXPECT_NE(refused([](ImageEdgeOptions* o) { o->max_gradient = 0.5; }), "");
  EXPECT_NE(refused([](ImageEdgeOptions* o) { o->weak_ratio = 1.1; }), "");
  EXPECT_NE(refused([](ImageEdgeOptions* o) { o->min_chain_px = 0; }), "");
  EXPECT_EQ(refused([](ImageEdgeOptions*) {}), "");
}

}  // namespace
}  // namespace cpplus
