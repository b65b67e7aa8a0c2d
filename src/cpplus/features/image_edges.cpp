#include "cpplus/features/image_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cpplus/core/fast_log.h"
#include "cpplus/core/options.h"
#include "cpplus/core/vector_clones.h"
#include "cpplus/features/edge_chains.h"
#include "cpplus/features/image_gradient.h"

namespace cpplus {
namespace {

constexpr float kGradientGain = ImageGradient::kUnitsPerLevel;

/// The magnitude of every second pixel of a row in steps of 1 / bins_per_level grey levels per pixel.
CPPLUS_VECTOR_CLONES void magnitude_bins(const int16_t* __restrict dx, const int16_t* __restrict dy, size_t count,
                                         float bins_per_level, uint16_t* __restrict bins) {
  for (size_t i = 0; i < count; ++i) {
    const float gx = dx[2 * i];
    const float gy = dy[2 * i];
    bins[i] = static_cast<uint16_t>(static_cast<int>(std::sqrt(gx * gx + gy * gy) * (bins_per_level / kGradientGain)));
  }
}

/// Distribution of the gradient's magnitude over every second pixel of every second row.
class GradientHistogram {
 public:
  explicit GradientHistogram(const ImageGradient& gradient) : counts_(kBins, 0) {
    std::vector<uint16_t> bins(static_cast<size_t>(gradient.width / 2));
    for (int y = 0; y < gradient.height; y += 2) {
      const size_t first = gradient.index(0, y);
      magnitude_bins(&gradient.dx[first], &gradient.dy[first], bins.size(), kBinsPerLevel, bins.data());
      for (const uint16_t bin : bins) ++counts_[std::min<size_t>(bin, kBins - 1)];
      total_ += bins.size();
    }
  }

  /// Grey levels per pixel.
  double quantile(double share) const {
    const double wanted = share * static_cast<double>(total_);
    double below = 0.0;
    for (size_t bin = 0; bin < kBins; ++bin) {
      const auto count = static_cast<double>(counts_[bin]);
      if (below + count > wanted) return (static_cast<double>(bin) + (wanted - below) / count) / kBinsPerLevel;
      below += count;
    }
    return 0.0;
  }

 private:
  static constexpr int kBinsPerLevel = 16;
  static constexpr size_t kBins = 128 * kBinsPerLevel;
  std::vector<uint32_t> counts_;
  size_t total_ = 0;
};

double strong_threshold(const ImageGradient& gradient, const ImageEdgeOptions& options) {
  const GradientHistogram histogram(gradient);
  // Of pure noise the magnitude has Rayleigh's distribution, whose q-quantile is sigma * sqrt(-2 ln(1 - q)).
  constexpr double kSmoothShare = 0.2;
  const double noise_sigma = histogram.quantile(kSmoothShare) / std::sqrt(-2.0 * std::log(1.0 - kSmoothShare));
  const double least = std::max(options.min_gradient, options.noise_ratio * noise_sigma);
  return std::min(std::max(histogram.quantile(options.strong_quantile), least), options.max_gradient);
}

/// Finds the sub-pixel places of edge pixels, some at a time so that the arithmetic becomes vector instructions.
class EdgelLocator {
 public:
  EdgelLocator(const ImageGradient& gradient, std::vector<ImageEdgel>* edgels) : gradient_(gradient), edgels_(edgels) {}

  /// A pixel that is not at the image's border.
  void add(int x, int y) {
    x_[count_] = static_cast<float>(x);
    y_[count_] = static_cast<float>(y);
    for (int row = 0; row < 3; ++row) {
      const size_t first = gradient_.index(x - 1, y + row - 1);
      for (size_t column = 0; column < 3; ++column) {
        const size_t k = 3 * static_cast<size_t>(row) + column;
        dx_[k][count_] = gradient_.dx[first + column];
        dy_[k][count_] = gradient_.dy[first + column];
      }
    }
    if (++count_ == kBlock) flush();
  }

  void flush() {
    take_logarithms();
    locate();
    for (size_t i = 0; i < count_; ++i) {
      if (!is_maximum_[i]) continue;
      edgels_->push_back({{x_[i], y_[i]}, {normal_x_[i], normal_y_[i]}, gradient_at_[i]});
    }
    count_ = 0;
  }

 private:
  static constexpr size_t kBlock = 64;
  static constexpr size_t kCenter = 4;
  using Floats = std::array<float, kBlock>;

  /// log2 of the squared gradients, to less than their own rounding.
  CPPLUS_VECTOR_CLONES void take_logarithms() {
    for (size_t k = 0; k < f_.size(); ++k) {
      for (size_t i = 0; i < kBlock; ++i) {
        const float gx = dx_[k][i];
        const float gy = dy_[k][i];
        f_[k][i] = fast_log2(gx * gx + gy * gy + 1.0f);
      }
    }
  }

  /// Moves each place to the maximum of log |gradient| across the edge; is_maximum_: there is one within one pixel.
  CPPLUS_VECTOR_CLONES void locate() {
    const auto& f = f_;
    for (size_t i = 0; i < kBlock; ++i) {
      // Least-squares quadratic: first and second differences averaged over the three rows or columns.
      const float left = f[0][i] + f[3][i] + f[6][i];
      const float right = f[2][i] + f[5][i] + f[8][i];
      const float above = f[0][i] + f[1][i] + f[2][i];
      const float below = f[6][i] + f[7][i] + f[8][i];
      const float fx = (right - left) / 6.0f;
      const float fy = (below - above) / 6.0f;
      const float fxx = (left + right - 2.0f * (f[1][i] + f[4][i] + f[7][i])) / 3.0f;
      const float fyy = (above + below - 2.0f * (f[3][i] + f[4][i] + f[5][i])) / 3.0f;
      const float fxy = (f[0][i] + f[8][i] - f[2][i] - f[6][i]) / 4.0f;

      const float gx = dx_[kCenter][i];
      const float gy = dy_[kCenter][i];
      const float magnitude = std::sqrt(gx * gx + gy * gy);
      const float normal_x = gx / magnitude;
      const float normal_y = gy / magnitude;
      const float slope = fx * normal_x + fy * normal_y;
      const float curvature = fxx * normal_x * normal_x + 2.0f * fxy * normal_x * normal_y + fyy * normal_y * normal_y;
      is_maximum_[i] = (curvature < 0.0f) & (std::abs(slope) <= -curvature);
      const float offset = slope / curvature;
      x_[i] -= offset * normal_x;
      y_[i] -= offset * normal_y;
      normal_x_[i] = normal_x;
      normal_y_[i] = normal_y;
      gradient_at_[i] = magnitude / kGradientGain;
    }
  }

  const ImageGradient& gradient_;
  std::vector<ImageEdgel>* edgels_;
  size_t count_ = 0;
  std::array<std::array<int16_t, kBlock>, 9> dx_{}, dy_{};  // of a pixel and its eight neighbours, row by row
  std::array<Floats, 9> f_;
  Floats x_{}, y_{}, normal_x_, normal_y_;
  Floats gradient_at_;  // grey levels per pixel
  std::array<uint8_t, kBlock> is_maximum_;
};

}  // namespace

void ImageEdgeOptions::validate() const {
  check_option(sigma_px >= 0.5 && sigma_px <= 5.0, "sigma_px", "[0.5, 5]", sigma_px);
  check_option(strong_quantile > 0.0 && strong_quantile < 1.0, "strong_quantile", "(0, 1)", strong_quantile);
  check_option(noise_ratio >= 0.0 && std::isfinite(noise_ratio), "noise_ratio", "[0, inf)", noise_ratio);
  check_option(min_gradient >= 0.1 && min_gradient <= 127.0, "min_gradient", "[0.1, 127]", min_gradient);
  check_option(max_gradient >= min_gradient && max_gradient <= 127.0, "max_gradient", "[min_gradient, 127]",
               max_gradient);
  check_option(weak_ratio > 0.0 && weak_ratio <= 1.0, "weak_ratio", "(0, 1]", weak_ratio);
  check_option(min_chain_px >= 1, "min_chain_px", "[1, inf)", min_chain_px);
}

ImageEdges detect_image_edges(const GrayImage& image, const ImageEdgeOptions& options) {
  options.validate();
  ImageEdges edges;
  edges.width = image.width;
  edges.height = image.height;
  const int margin = static_cast<int>(std::ceil(2.0 * options.sigma_px)) + 1;
  if (image.width <= 2 * margin || image.height <= 2 * margin) return edges;

  const ImageGradient gradient = blurred_gradient(image, options.sigma_px);
  const double strong = strong_threshold(gradient, options) * kGradientGain;
  const EdgeChains chains = find_edge_chains(gradient, options.weak_ratio * strong, strong);
  edges.edgels.reserve(chains.pixels.size());
  EdgelLocator locator(gradient, &edges.edgels);
  for (const EdgePixel& pixel : chains.pixels) {
    const bool inside =
        pixel.x >= margin && pixel.y >= margin && pixel.x < image.width - margin && pixel.y < image.height - margin;
    if (!inside || chains.sizes[pixel.chain] < static_cast<uint32_t>(options.min_chain_px)) continue;
    locator.add(pixel.x, pixel.y);
  }
  locator.flush();
  return edges;
}

}  // namespace cpplus
