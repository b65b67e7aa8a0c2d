#include "cpplus/features/image_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
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

/// log2 of the squared gradient, to less than its own rounding, at (x, y) and its eight neighbours, row by row; a
/// fourth column fills up the vectors.
std::array<float, 12> log_gradient_3x3(const ImageGradient& gradient, int x, int y) {
  std::array<float, 12> f;
  for (int row = 0; row < 3; ++row) {
    const size_t first = gradient.index(x - 1, y + row - 1);
    std::array<int16_t, 4> dx, dy;
    std::copy_n(&gradient.dx[first], 4, dx.begin());
    std::copy_n(&gradient.dy[first], 4, dy.begin());
    for (int column = 0; column < 4; ++column) {
      const float gx = dx[column];
      const float gy = dy[column];
      f[4 * row + column] = fast_log2(gx * gx + gy * gy + 1.0f);
    }
  }
  return f;
}

/// The edgel of an edge pixel; nothing where log |gradient| has no maximum across the edge within one pixel.
std::optional<ImageEdgel> locate(const ImageGradient& gradient, int x, int y) {
  const std::array<float, 12> f = log_gradient_3x3(gradient, x, y);
  // Least-squares quadratic: first and second differences averaged over the three rows or columns.
  const float left = f[0] + f[4] + f[8];
  const float right = f[2] + f[6] + f[10];
  const float above = f[0] + f[1] + f[2];
  const float below = f[8] + f[9] + f[10];
  const float fx = (right - left) / 6.0f;
  const float fy = (below - above) / 6.0f;
  const float fxx = (left + right - 2.0f * (f[1] + f[5] + f[9])) / 3.0f;
  const float fyy = (above + below - 2.0f * (f[4] + f[5] + f[6])) / 3.0f;
  const float fxy = (f[0] + f[10] - f[2] - f[8]) / 4.0f;

  const size_t center = gradient.index(x, y);
  const Eigen::Vector2f d(gradient.dx[center], gradient.dy[center]);
  const float magnitude = d.norm();
  const Eigen::Vector2f normal = d / magnitude;
  const float slope = fx * normal.x() + fy * normal.y();
  const float curvature =
      fxx * normal.x() * normal.x() + 2.0f * fxy * normal.x() * normal.y() + fyy * normal.y() * normal.y();
  if (!(curvature < 0.0f) || !(std::abs(slope) <= -curvature)) return std::nullopt;
  ImageEdgel edgel;
  edgel.pixel = Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - slope / curvature * normal;
  edgel.normal = normal;
  edgel.gradient = magnitude / kGradientGain;
  return edgel;
}

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
  for (const EdgePixel& pixel : chains.pixels) {
    const bool inside =
        pixel.x >= margin && pixel.y >= margin && pixel.x < image.width - margin && pixel.y < image.height - margin;
    if (!inside || chains.sizes[pixel.chain] < static_cast<uint32_t>(options.min_chain_px)) continue;
    if (const std::optional<ImageEdgel> edgel = locate(gradient, pixel.x, pixel.y)) edges.edgels.push_back(*edgel);
  }
  return edges;
}

}  // namespace cpplus
