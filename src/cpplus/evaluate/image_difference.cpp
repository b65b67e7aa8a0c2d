#include "cpplus/evaluate/image_difference.h"

#include <cmath>
#include <limits>

#include "cpplus/core/error.h"

namespace cpplus {

ImageDifference compare_images(const ColorImage& photo, const ColorImage& rendering, const Image<uint8_t>& covered) {
  if (photo.width != rendering.width || photo.height != rendering.height || photo.width != covered.width ||
      photo.height != covered.height) {
    throw Error("images of different sizes cannot be compared");
  }
  ImageDifference result;
  result.num_pixels = photo.pixels.size();
  // Sums of squares and products give both errors in one pass, and are exact.
  double photo_square = 0.0, rendering_square = 0.0, product = 0.0;
  for (size_t i = 0; i < photo.pixels.size(); ++i) {
    if (covered.pixels[i] == 0) continue;
    ++result.num_covered;
    for (size_t c = 0; c < 3; ++c) {
      const double p = photo.pixels[i][c], r = rendering.pixels[i][c];
      photo_square += p * p;
      rendering_square += r * r;
      product += p * r;
    }
  }
  if (result.num_covered == 0) return result;
  if (rendering_square > 0.0) result.scale = product / rendering_square;
  const auto mean_square = [&](double scale) {
    const double sum = photo_square - 2.0 * scale * product + scale * scale * rendering_square;
    return sum / (3.0 * static_cast<double>(result.num_covered));
  };
  result.mean_square = mean_square(1.0);
  result.matched_mean_square = mean_square(result.scale);
  return result;
}

double psnr_db(double mean_square) {
  if (mean_square <= 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(255.0 * 255.0 / mean_square);
}

}  // namespace cpplus
