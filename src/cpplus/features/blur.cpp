#include "cpplus/features/blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "cpplus/core/for_each_set.h"
#include "cpplus/core/nth_smallest.h"
#include "cpplus/core/options.h"
#include "cpplus/core/vector_clones.h"
#include "cpplus/features/image_gradient.h"

namespace cpplus {
namespace {

constexpr int kLevels = 256;
constexpr int kNumDirections = 8;
constexpr double kFineSigmaPx = 1.0;
constexpr double kCoarseSigmaHalfPx = 1.5;  // on the image of half size: 3 px
constexpr double kMinCoarseGradient = 0.3;  // grey levels per pixel
constexpr double kNoiseRatio = 1.0;         // least coarse gradient per pixel of an edge that counts / noise
constexpr double kStrongGradient = 3.0;     // grey levels per pixel: softer ones may be mottled plaster or shading ...
constexpr double kStrongRatio = 0.25;       // ... unless the image's strongest edges are little stronger themselves
constexpr double kStrongestShare = 0.5;     // of the edge pixels that count, around a direction
constexpr double kSharpnessQuantile = 0.9;  // among those
constexpr float kMinCosine = 0.7f;          // 45 degrees from the direction, where 0.7 of a smear still shows
constexpr int kSearchPx = 2;                // the sharp edge may lie beside the coarse one

/// A pixel of the half-size image where the coarse gradient has a maximum across the edge.
struct CoarseEdge {
  float x, y;
  float gradient;            // grey levels per full-size pixel
  float normal_x, normal_y;  // along the gradient
};

GrayImage to_image(const cv::Mat& gray) {
  GrayImage image(gray.cols, gray.rows);
  cv::Mat target(gray.rows, gray.cols, CV_8U, image.pixels.data());
  gray.copyTo(target);
  return image;
}

/// How many pixels have each grey level.
std::array<uint32_t, kLevels> count_levels(const cv::Mat& gray) {
  // Tables by turns: neighbours are often equal, and would wait for each other's count.
  constexpr int kTables = 4;
  std::array<std::array<uint32_t, kLevels>, kTables> tables{};
  for (int y = 0; y < gray.rows; ++y) {
    const uint8_t* row = gray.ptr<uint8_t>(y);
    int x = 0;
    for (; x + 8 <= gray.cols; x += 8) {
      uint64_t eight;
      std::memcpy(&eight, row + x, 8);
      for (size_t i = 0; i < 8; ++i) ++tables[i % kTables][eight >> (8 * i) & 0xff];
    }
    for (; x < gray.cols; ++x) ++tables[0][row[x]];
  }
  std::array<uint32_t, kLevels> counts{};
  for (const auto& table : tables) {
    for (size_t level = 0; level < kLevels; ++level) counts[level] += table[level];
  }
  return counts;
}

/// Histogram equalisation of limited contrast: a grey level counts at most its fair share of the pixels, what is cut
/// off is spread over all levels. Plain equalisation of an image of few flat surfaces tears their grey values apart,
/// and with them every smeared edge between them, which then looks sharp.
cv::Mat equalize(const cv::Mat& gray) {
  const std::array<uint32_t, kLevels> counts = count_levels(gray);
  const double fair_share = static_cast<double>(gray.total()) / kLevels;
  std::array<double, kLevels> shares;
  double kept = 0.0;
  for (int level = 0; level < kLevels; ++level) {
    shares[level] = std::min(counts[level] / fair_share, 1.0);
    kept += shares[level];
  }
  const double spread = (kLevels - kept) / (kLevels - 1);  // on every level but the darkest, which becomes 0
  cv::Mat table(1, kLevels, CV_8U);
  double value = 0.0;
  for (int level = 0; level < kLevels; ++level) {
    if (level > 0) value += shares[level] + spread;
    table.at<uint8_t>(level) = cv::saturate_cast<uint8_t>(value * (kLevels - 1) / (kLevels - shares[0]));
  }
  cv::Mat equalized;
  cv::LUT(gray, table, equalized);
  return equalized;
}

/// Reduced to the size limit, of even size, equalised.
cv::Mat prepare(const GrayImage& image, int max_size_px) {
  cv::Mat gray(image.height, image.width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
  const double scale = static_cast<double>(max_size_px) / std::max(image.width, image.height);
  cv::Mat reduced = gray;
  if (scale < 1.0) cv::resize(gray, reduced, cv::Size(), scale, scale, cv::INTER_AREA);
  return equalize(reduced(cv::Rect(0, 0, reduced.cols / 2 * 2, reduced.rows / 2 * 2)));
}

/// Standard deviation of the noise, grey levels: the median response to a mask that is blind to planes and to straight
/// edges along the axes, and whose norm is 6 (Immerkaer 1996). Every second pixel of every fourth row.
double noise_level(const cv::Mat& gray) {
  std::vector<uint32_t> histogram(16 * 256, 0);
  std::vector<int16_t> columns(static_cast<size_t>(gray.cols));
  size_t total = 0;
  for (int y = 1; y + 1 < gray.rows; y += 4) {
    const uint8_t* above = gray.ptr<uint8_t>(y - 1);
    const uint8_t* row = gray.ptr<uint8_t>(y);
    const uint8_t* below = gray.ptr<uint8_t>(y + 1);
    for (int x = 0; x < gray.cols; ++x) columns[x] = static_cast<int16_t>(above[x] - 2 * row[x] + below[x]);
    for (int x = 1; x + 1 < gray.cols; x += 2, ++total) {
      ++histogram[static_cast<size_t>(std::abs(columns[x - 1] - 2 * columns[x] + columns[x + 1]))];
    }
  }
  size_t below = 0;
  size_t median = 0;
  while (below + histogram[median] <= total / 2) below += histogram[median++];
  constexpr double kMedianOfAbsNormal = 0.6745;
  return static_cast<double>(median) / kMedianOfAbsNormal / 6.0;
}

/// Bilinear; the point must lie inside.
float sample(const cv::Mat& gray, float x, float y) {
  const auto column = static_cast<int>(x);
  const auto row = static_cast<int>(y);
  const float a = x - static_cast<float>(column);
  const float b = y - static_cast<float>(row);
  const uint8_t* upper = gray.ptr<uint8_t>(row) + column;
  const uint8_t* lower = upper + gray.step;
  return (1.0f - b) * ((1.0f - a) * upper[0] + a * upper[1]) + b * ((1.0f - a) * lower[0] + a * lower[1]);
}

/// Largest gradient of the finely blurred image along the edge's normal, near the edge; grey levels per pixel.
float fine_gradient(const cv::Mat& fine, const CoarseEdge& edge) {
  constexpr int kNumSamples = 2 * kSearchPx + 3;
  std::array<float, kNumSamples> profile;
  for (int k = 0; k < kNumSamples; ++k) {
    const auto offset = static_cast<float>(k - kSearchPx - 1);
    // Pixel (0, 0) of the half-size image covers (0, 0) to (1, 1) of the full size.
    profile[k] =
        sample(fine, 2.0f * edge.x + 0.5f + offset * edge.normal_x, 2.0f * edge.y + 0.5f + offset * edge.normal_y);
  }
  float largest = 0.0f;
  for (int k = 1; k + 1 < kNumSamples; ++k) largest = std::max(largest, 0.5f * (profile[k + 1] - profile[k - 1]));
  return largest;
}

/// For the pixels of a row of the gradient: is its square at least `least` and a maximum across the edge? Compared with
/// the neighbours nearest to the gradient's direction among four. `squared` holds the squares of all pixels, of which
/// the row and its `width` are not at the border. Without branches, so that the loop becomes vector instructions.
CPPLUS_VECTOR_CLONES void flag_maxima(const int16_t* dx, const int16_t* dy, const float* squared, ptrdiff_t stride,
                                      int width, float least, uint8_t* flags) {
  constexpr float kTan22 = 0.41421356f;
  for (int x = 0; x < width; ++x) {
    const float here = squared[x];
    const float across = std::abs(static_cast<float>(dx[x]));
    const float down = std::abs(static_cast<float>(dy[x]));
    const bool is_horizontal = down <= kTan22 * across;
    const bool is_vertical = !is_horizontal & (across <= kTan22 * down);
    const bool falls = (dx[x] > 0) == (dy[x] > 0);
    const bool horizontal = (here > squared[x - 1]) & (here >= squared[x + 1]);
    const bool vertical = (here > squared[x - stride]) & (here >= squared[x + stride]);
    const bool falling = (here > squared[x - stride - 1]) & (here >= squared[x + stride + 1]);
    const bool rising = (here > squared[x - stride + 1]) & (here >= squared[x + stride - 1]);
    const bool diagonal = (falls & falling) | (!falls & rising);
    flags[x] = (here >= least) &
               ((is_horizontal & horizontal) | (is_vertical & vertical) | (!is_horizontal & !is_vertical & diagonal));
  }
}

/// Does the edge belong to the black frame of a fisheye image, which no motion blurs? The darkest grey of an equalised
/// image is 0; it has to go on for a while on the dark side.
bool at_black_frame(const cv::Mat& gray, const CoarseEdge& edge) {
  constexpr int kBlack = 4;
  for (const float distance : {6.0f, 9.0f, 12.0f}) {
    const int x = std::clamp(static_cast<int>(2.0f * edge.x - distance * edge.normal_x), 0, gray.cols - 1);
    const int y = std::clamp(static_cast<int>(2.0f * edge.y - distance * edge.normal_y), 0, gray.rows - 1);
    if (gray.at<uint8_t>(y, x) > kBlack) return false;
  }
  return true;
}

std::vector<CoarseEdge> find_coarse_edges(const ImageGradient& coarse, const cv::Mat& gray) {
  constexpr int kMargin = 4;
  // The coarse gradient was taken per pixel of the half-size image.
  constexpr float kCoarseUnits = 2.0f * ImageGradient::kUnitsPerLevel;
  constexpr auto kLeast = static_cast<float>(kMinCoarseGradient) * kCoarseUnits;
  std::vector<float> squared(coarse.dx.size());
  for (size_t i = 0; i < squared.size(); ++i) {
    const float dx = coarse.dx[i];
    const float dy = coarse.dy[i];
    squared[i] = dx * dx + dy * dy;
  }
  std::vector<CoarseEdge> edges;
  std::vector<uint8_t> flags(static_cast<size_t>(coarse.width), 0);
  for (int y = kMargin; y < coarse.height - kMargin; ++y) {
    const size_t first = coarse.index(kMargin, y);
    flag_maxima(&coarse.dx[first], &coarse.dy[first], &squared[first], coarse.width, coarse.width - 2 * kMargin,
                kLeast * kLeast, &flags[kMargin]);
    for_each_set(flags.data(), flags.size(), [&](size_t x) {
      const size_t i = coarse.index(static_cast<int>(x), y);
      const float magnitude = std::sqrt(squared[i]);
      const float normal_x = coarse.dx[i] / magnitude;
      const float normal_y = coarse.dy[i] / magnitude;
      const CoarseEdge edge{static_cast<float>(x), static_cast<float>(y), magnitude / kCoarseUnits, normal_x, normal_y};
      if (!at_black_frame(gray, edge)) edges.push_back(edge);
    });
  }
  return edges;
}

/// An edge that is strong enough to tell sharp from smeared.
struct JudgedEdge {
  float gradient;
  float sharpness;  // fine / coarse gradient
  float normal_x, normal_y;
};

/// The coarse gradient that an edge needs to count: well above the noise, and above what soft texture has.
double least_gradient(const std::vector<CoarseEdge>& edges, double noise, size_t min_edges) {
  if (edges.size() < min_edges) return kStrongGradient;
  std::vector<float> gradients;
  for (const CoarseEdge& edge : edges) gradients.push_back(edge.gradient);
  const auto strongest = static_cast<double>(nth_smallest(gradients, gradients.size() - min_edges));
  return std::max(kNoiseRatio * noise, std::min(kStrongGradient, kStrongRatio * strongest));
}

std::vector<JudgedEdge> judge_edges(const std::vector<CoarseEdge>& edges, const cv::Mat& fine, double least_gradient) {
  std::vector<JudgedEdge> judged;
  for (const CoarseEdge& edge : edges) {
    if (edge.gradient < least_gradient) continue;
    judged.push_back({edge.gradient, fine_gradient(fine, edge) / edge.gradient, edge.normal_x, edge.normal_y});
  }
  return judged;
}

/// Upper quantile of the sharpness among the strongest edges within 45 degrees of a direction, all of which a smear in
/// that direction would have softened; 0 when there are too few.
double sharpness_around(const std::vector<JudgedEdge>& judged, double direction_rad, size_t min_edges) {
  const auto x = static_cast<float>(std::cos(direction_rad));
  const auto y = static_cast<float>(std::sin(direction_rad));
  std::vector<float> gradients, sharpnesses;
  for (const JudgedEdge& edge : judged) {
    if (std::abs(edge.normal_x * x + edge.normal_y * y) < kMinCosine) continue;
    gradients.push_back(edge.gradient);
    sharpnesses.push_back(edge.sharpness);
  }
  if (gradients.size() < min_edges) return 0.0;
  const auto share = static_cast<size_t>(kStrongestShare * static_cast<double>(gradients.size()));
  const float least = nth_smallest(gradients, gradients.size() - std::max(min_edges, share));
  size_t count = 0;
  for (size_t i = 0; i < gradients.size(); ++i) {
    // Written in any case: the next one takes the place of one that is too soft.
    sharpnesses[count] = sharpnesses[i];
    count += gradients[i] >= least;
  }
  const auto at = static_cast<size_t>(kSharpnessQuantile * static_cast<double>(count - 1));
  return static_cast<double>(nth_smallest(std::span(sharpnesses).first(count), at));
}

}  // namespace

void BlurOptions::validate() const {
  check_option(min_sharpness >= 1.0 && min_sharpness <= 3.0, "min_sharpness", "[1, 3]", min_sharpness);
  check_option(max_size_px >= 64, "max_size_px", "[64, inf)", max_size_px);
  check_option(min_edges >= 1, "min_edges", "[1, inf)", min_edges);
}

BlurResult measure_blur(const GrayImage& image, const BlurOptions& options) {
  options.validate();
  BlurResult result;
  constexpr int kMinSize = 32;
  if (std::min(image.width, image.height) < kMinSize) return result;
  const cv::Mat gray = prepare(image, options.max_size_px);
  if (std::min(gray.cols, gray.rows) < kMinSize) return result;
  cv::Mat half;
  cv::resize(gray, half, cv::Size(gray.cols / 2, gray.rows / 2), 0, 0, cv::INTER_AREA);
  const std::vector<CoarseEdge> edges = find_coarse_edges(blurred_gradient(to_image(half), kCoarseSigmaHalfPx), gray);
  cv::Mat fine;
  cv::GaussianBlur(gray, fine, cv::Size(), kFineSigmaPx);
  const auto min_edges = static_cast<size_t>(options.min_edges);
  const std::vector<JudgedEdge> judged = judge_edges(edges, fine, least_gradient(edges, noise_level(gray), min_edges));
  for (int i = 0; i < kNumDirections; ++i) {
    const double sharpness = sharpness_around(judged, M_PI * i / kNumDirections, min_edges);
    if (sharpness == 0.0) continue;
    ++result.num_directions;
    if (result.num_directions > 1 && sharpness >= result.sharpness) continue;
    result.sharpness = sharpness;
    result.direction_deg = 180.0 * i / kNumDirections;
  }
  result.blurred = result.num_directions > 0 && result.sharpness < options.min_sharpness;
  return result;
}

}  // namespace cpplus
