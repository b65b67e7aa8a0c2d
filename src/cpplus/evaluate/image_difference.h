#pragma once

#include <cstddef>

#include "cpplus/core/image.h"

namespace cpplus {

/// How far a rendering is from a photo, over the pixels that the rendering covers.
struct ImageDifference {
  size_t num_pixels = 0;             // of the image
  size_t num_covered = 0;            // compared
  double mean_square = 0.0;          // of the differences of all channels, grey levels squared
  double matched_mean_square = 0.0;  // the same after the rendering was scaled by `scale`
  double scale = 1.0;                // makes up for the photo's own exposure, best in the sense of least squares
};

/// `covered`: 0 where the rendering shows nothing. Throws Error where the three are not of one size.
ImageDifference compare_images(const ColorImage& photo, const ColorImage& rendering, const Image<uint8_t>& covered);

/// Peak signal-to-noise ratio, dB: 10 log10(255^2 / mean_square); +inf for 0.
double psnr_db(double mean_square);

}  // namespace cpplus
