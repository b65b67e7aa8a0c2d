#include "cpplus/features/blur.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

GrayImage to_image(const cv::Mat& gray) {
  GrayImage image(gray.cols, gray.rows);
  std::copy(gray.begin<uint8_t>(), gray.end<uint8_t>(), image.pixels.begin());
  return image;
}

BlurResult measure(const cv::Mat& gray) { return measure_blur(to_image(gray), {}); }

/// Overlapping squares of random size, turn and grey: edges in all directions, rendered without aliasing.
cv::Mat squares(int width, int height, uint64_t seed, double max_turn = M_PI) {
  constexpr int kScale = 4;
  cv::Mat large(height * kScale, width * kScale, CV_8U, cv::Scalar(128));
  Random random(seed);
  for (int i = 0; i < 150; ++i) {
    const cv::Point2d center(random.uniform(0, large.cols), random.uniform(0, large.rows));
    const double radius = random.uniform(20, 90) * kScale;
    const double turn = random.uniform(-max_turn, max_turn) + M_PI / 4;
    std::vector<cv::Point> corners;
    for (int k = 0; k < 4; ++k) {
      const double angle = turn + k * M_PI / 2;
      corners.emplace_back(center + radius * cv::Point2d(std::cos(angle), std::sin(angle)));
    }
    cv::fillConvexPoly(large, corners, cv::Scalar(random.uniform(20, 235)));
  }
  cv::Mat image;
  cv::resize(large, image, cv::Size(width, height), 0, 0, cv::INTER_AREA);
  return image;
}

cv::Mat smear(const cv::Mat& gray, double length_px, double direction_deg) {
  const int size = 2 * static_cast<int>(std::ceil(length_px / 2)) + 3;
  cv::Mat kernel(size, size, CV_32F, cv::Scalar(0));
  const double angle = direction_deg * M_PI / 180.0;
  const int steps = static_cast<int>(length_px * 8);
  for (int i = 0; i < steps; ++i) {
    const double t = length_px * ((i + 0.5) / steps - 0.5);
    const double x = size / 2 + t * std::cos(angle);
    const double y = size / 2 + t * std::sin(angle);
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const auto a = static_cast<float>(x - column);
    const auto b = static_cast<float>(y - row);
    kernel.at<float>(row, column) += (1 - a) * (1 - b);
    kernel.at<float>(row, column + 1) += a * (1 - b);
    kernel.at<float>(row + 1, column) += (1 - a) * b;
    kernel.at<float>(row + 1, column + 1) += a * b;
  }
  cv::Mat smeared;
  cv::filter2D(gray, smeared, -1, kernel / static_cast<double>(steps), cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  return smeared;
}

/// Darkened as by a short exposure, with the noise that this brings.
cv::Mat low_light(const cv::Mat& gray, double gain, double noise, uint64_t seed) {
  Random random(seed);
  cv::Mat dark(gray.size(), CV_8U);
  for (int y = 0; y < gray.rows; ++y) {
    for (int x = 0; x < gray.cols; ++x) {
      dark.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(gain * gray.at<uint8_t>(y, x) + noise * random.normal());
    }
  }
  return dark;
}

double turn_between_deg(double a, double b) { return std::abs(std::remainder(a - b, 180.0)); }

// ---- by hand ----

TEST(Blur, RatioOfTwoGaussiansAcrossOneStep) {
  // Step of width s: sqrt((s^2 + 3^2) / (s^2 + 1)), plus what the pixels and the differences add to both.
  for (const double s : {0.0, 1.0, 2.0, 4.0}) {
    cv::Mat image(400, 400, CV_8U);
    for (int y = 0; y < 400; ++y) {
      for (int x = 0; x < 400; ++x) image.at<uint8_t>(y, x) = (x / 40) % 2 ? 180 : 70;
    }
    if (s > 0.0) cv::GaussianBlur(image, image, cv::Size(), s);
    const BlurResult result = measure(image);
    const double s2 = s * s + 1.0 / 12.0;
    EXPECT_NEAR(result.sharpness, std::sqrt((s2 + 9.0 + 4.0 / 3.0) / (s2 + 1.0 + 1.0 / 3.0)), 0.2) << s;
    EXPECT_EQ(result.num_directions, 5);  // up to 45 degrees from the only edges
    EXPECT_EQ(result.direction_deg, 0.0);
  }
}

// ---- smears ----

TEST(Blur, SmearIsSeenInItsDirection) {
  const cv::Mat image = squares(640, 480, 1);
  const BlurResult sharp = measure(image);
  EXPECT_FALSE(sharp.blurred);
  EXPECT_GT(sharp.sharpness, 2.5);
  EXPECT_EQ(sharp.num_directions, 8);
  for (const double direction : {0.0, 22.5, 45.0, 90.0, 135.0}) {
    double last = sharp.sharpness;
    for (const double length : {8.0, 14.0, 22.0, 30.0}) {
      const BlurResult result = measure(smear(image, length, direction));
      EXPECT_TRUE(result.blurred) << length << " " << direction;
      EXPECT_LT(result.sharpness, last + 0.05) << length << " " << direction;
      EXPECT_LE(turn_between_deg(result.direction_deg, direction), 22.5) << length << " " << direction;
      last = result.sharpness;
    }
  }
}

TEST(Blur, SmearAlongTheOnlyEdgesCannotBeSeen) {
  cv::Mat rows(400, 400, CV_8U);
  for (int y = 0; y < 400; ++y) rows.row(y) = (y / 40) % 2 ? 180 : 70;
  EXPECT_FALSE(measure(smear(rows, 20, 0)).blurred);
  EXPECT_TRUE(measure(smear(rows, 20, 90)).blurred);
}

TEST(Blur, OutOfFocusIsBlurredEverywhere) {
  cv::Mat image = squares(640, 480, 2);
  cv::GaussianBlur(image, image, cv::Size(), 2.5);
  EXPECT_TRUE(measure(image).blurred);
}

TEST(Blur, LowLightAndLowContrastDoNotChangeTheVerdict) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const cv::Mat sharp = squares(640, 480, seed);
    const cv::Mat smeared = smear(sharp, 14, 30.0 * static_cast<double>(seed));
    for (const double noise : {0.5, 1.0, 2.0}) {
      EXPECT_FALSE(measure(low_light(sharp, 0.2, noise, seed)).blurred) << seed << " " << noise;
      EXPECT_TRUE(measure(low_light(smeared, 0.2, noise, seed)).blurred) << seed << " " << noise;
    }
    EXPECT_FALSE(measure(sharp * 0.1 + 100).blurred);
    EXPECT_TRUE(measure(smeared * 0.1 + 100).blurred);
  }
}

TEST(Blur, BlackFrameOfAFisheyeDoesNotHideTheSmear) {
  cv::Mat circle(480, 640, CV_8U, cv::Scalar(0));
  cv::circle(circle, cv::Point(320, 240), 230, cv::Scalar(255), cv::FILLED, cv::LINE_AA);
  cv::Mat framed;
  cv::multiply(smear(squares(640, 480, 3), 16, 60), circle, framed, 1.0 / 255);
  EXPECT_TRUE(measure(framed).blurred);
  cv::multiply(squares(640, 480, 3), circle, framed, 1.0 / 255);
  EXPECT_FALSE(measure(framed).blurred);
}

TEST(Blur, LargeImagesAreJudgedAtTheReducedSize) {
  // A camera of 2560 pixels that is soft by 1.5 pixels is sharp at 1280.
  cv::Mat image = squares(2560, 1440, 4);
  cv::GaussianBlur(image, image, cv::Size(), 1.5);
  EXPECT_FALSE(measure(image).blurred);
  BlurOptions full_size;
  full_size.max_size_px = 2560;
  EXPECT_TRUE(measure_blur(to_image(image), full_size).blurred);
}

// ---- bare scenes ----

/// Floor, ceiling and walls that meet in a vanishing point, a lamp, and plaster whose mottles are `grain_px` wide: the
/// few edges that are sharp leave most orientations without any.
cv::Mat bare_corridor(double contrast, double mottle, int grain_px, uint64_t seed) {
  constexpr int kScale = 4;
  const cv::Point2d end(300 * kScale, 230 * kScale);
  cv::Mat large(480 * kScale, 640 * kScale, CV_8U, cv::Scalar(150));
  const auto fill = [&](std::vector<cv::Point2d> corners, double gray) {
    std::vector<cv::Point> points;
    for (const cv::Point2d& corner : corners) points.emplace_back(corner);
    cv::fillConvexPoly(large, points, cv::Scalar(150 + contrast * gray));
  };
  fill({end, cv::Point2d(0, large.rows), cv::Point2d(large.cols, large.rows)}, -60);
  fill({end, cv::Point2d(0, 0), cv::Point2d(large.cols, 0)}, -20);
  fill({end, cv::Point2d(1100, 0), cv::Point2d(1250, 0)}, 100);
  cv::Mat image;
  cv::resize(large, image, cv::Size(640, 480), 0, 0, cv::INTER_AREA);
  Random random(seed);
  cv::Mat grain(480 / grain_px, 640 / grain_px, CV_32F);
  for (int i = 0; i < grain.rows * grain.cols; ++i) grain.at<float>(i) = static_cast<float>(mottle * random.normal());
  cv::Mat plaster;
  cv::resize(grain, plaster, image.size(), 0, 0, cv::INTER_CUBIC);
  image.convertTo(image, CV_32F);
  image += plaster;
  image.convertTo(image, CV_8U);
  return low_light(image, 1.0, 1.0, seed);
}

TEST(Blur, SoftTextureDoesNotCondemnABareScene) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    for (const double mottle : {4.0, 8.0}) {
      const cv::Mat sharp = bare_corridor(1.0, mottle, 16, seed);
      EXPECT_FALSE(measure(sharp).blurred) << seed << " " << mottle << ": " << measure(sharp).sharpness;
      for (const double direction : {0.0, 30.0, 60.0, 90.0, 150.0}) {
        EXPECT_TRUE(measure(smear(sharp, 14, direction)).blurred) << seed << " " << mottle << " " << direction;
      }
      cv::Mat unfocused;
      cv::GaussianBlur(sharp, unfocused, cv::Size(), 2.5);
      EXPECT_TRUE(measure(unfocused).blurred) << seed << " " << mottle;
    }
  }
}

TEST(Blur, SharpEdgesUpTo45DegreesFromADirectionSpeakAgainstASmearInIt) {
  // Sharp diamonds, and the soft edge of a shadow along the rows.
  cv::Mat image(400, 400, CV_8U);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      const double shadow = 40 * std::tanh((y - 200) / 6.0);
      image.at<uint8_t>(y, x) =
          cv::saturate_cast<uint8_t>((((x + y) / 40 + (x - y + 400) / 40) % 2 ? 160 : 90) + shadow);
    }
  }
  EXPECT_FALSE(measure(image).blurred);
  EXPECT_TRUE(measure(smear(image, 14, 45)).blurred);
  EXPECT_TRUE(measure(smear(image, 14, 90)).blurred);
}

// ---- nothing to judge, bad input ----

TEST(Blur, ImagesWithoutEdgesAreNotBlurred) {
  EXPECT_EQ(measure_blur(GrayImage(), {}).num_directions, 0);
  EXPECT_EQ(measure_blur(GrayImage(10, 300, 9), {}).num_directions, 0);
  EXPECT_EQ(measure_blur(GrayImage(300, 300, 9), {}).num_directions, 0);
  for (const double noise : {1.0, 4.0, 12.0}) {
    EXPECT_FALSE(measure(low_light(cv::Mat(480, 640, CV_8U, cv::Scalar(120)), 1.0, noise, 5)).blurred) << noise;
  }
}

TEST(Blur, OptionsOutOfRangeAreRefused) {
  const auto refused = [](const std::function<void(BlurOptions*)>& change) {
    BlurOptions options;
    change(&options);
    try {
      measure_blur(GrayImage(40, 40), options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused([](BlurOptions* o) { o->min_sharpness = 0; }), "option min_sharpness must be in [1, 3], got 0");
  EXPECT_NE(refused([](BlurOptions* o) { o->max_size_px = 10; }), "");
  EXPECT_NE(refused([](BlurOptions* o) { o->min_edges = 0; }), "");
  EXPECT_EQ(refused([](BlurOptions*) {}), "");
}

// ---- scenes ----

struct SceneImage {
  fs::path path;
  bool blurred;
};

std::vector<SceneImage> scene_images() {
  std::vector<SceneImage> images;
  for (const char* kind : {"truth", "recorded"}) {
    const fs::path folder = fs::path(CPPLUS_DATA_DIR) / kind;
    if (!fs::exists(folder)) continue;
    for (const fs::directory_entry& scene : fs::directory_iterator(folder)) {
      if (!fs::exists(scene.path() / "images")) continue;
      std::set<std::string> blurred;
      std::ifstream list(scene.path() / "truth" / "blurred.txt");
      for (std::string name; list >> name;) blurred.insert(name);
      for (const fs::directory_entry& file : fs::directory_iterator(scene.path() / "images")) {
        images.push_back({file.path(), blurred.count(file.path().filename().string()) > 0});
      }
    }
  }
  return images;
}

TEST(SlowBlurOnScenes, BlurredImagesAndNoOthers) {
  const std::vector<SceneImage> images = scene_images();
  if (images.empty()) GTEST_SKIP() << "no scenes in " << CPPLUS_DATA_DIR;
  for (const SceneImage& image : images) {
    const BlurResult result = measure(cv::imread(image.path.string(), cv::IMREAD_GRAYSCALE));
    EXPECT_EQ(result.blurred, image.blurred) << image.path << " sharpness " << result.sharpness;
    EXPECT_GT(result.num_directions, 0) << image.path;
  }
}

TEST(SlowBlurOnScenes, SmearedByUs) {
  const std::vector<SceneImage> images = scene_images();
  if (images.empty()) GTEST_SKIP() << "no scenes in " << CPPLUS_DATA_DIR;
  Random random(8);
  int seen = 0;
  int tried = 0;
  for (const SceneImage& image : images) {
    if (image.blurred) continue;
    const cv::Mat gray = cv::imread(image.path.string(), cv::IMREAD_GRAYSCALE);
    // The length is that in the image reduced to 1280 pixels.
    const double scale = std::max(1.0, gray.cols / 1280.0);
    const cv::Mat smeared = smear(gray, scale * random.uniform(12, 30), random.uniform(0, 180));
    seen += measure(low_light(smeared, random.uniform(0.3, 1.0), 1.0, random.next())).blurred;
    ++tried;
  }
  EXPECT_GE(seen, 0.97 * tried) << tried;
}

}  // namespace
}  // namespace cpplus
