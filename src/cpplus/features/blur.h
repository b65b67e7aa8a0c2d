#pragma once

#include "cpplus/core/image.h"

namespace cpplus {

struct BlurOptions {
  /// An image is blurred when its sharpness (see BlurResult) is below this. Sharp images have 2.4 and more, smears of
  /// 12 pixels at most 2.0, of 8 pixels about 2.0 (docs/image_edges.md). [1, 3]
  double min_sharpness = 2.3;
  /// The longer side of the image is first reduced to at most this, pixels: large sensors are soft at the scale of
  /// single pixels without being blurred. [64, inf)
  int max_size_px = 1280;
  /// A direction with fewer strong edge pixels across it does not take part in the verdict. [1, inf)
  int min_edges = 60;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("min_sharpness", min_sharpness, "Images of less sharpness count as blurred. [1, 3]");
    visitor("max_size_px", max_size_px, "The blur is measured on an image reduced to this size. [64, inf)");
    visitor("min_edges", min_edges, "Strong edge pixels across a direction for it to take part. [1, inf)");
  }
};

struct BlurResult {
  bool blurred = false;
  /// Of the least sharp direction: gradient after a fine blur / gradient after a three times coarser one, across strong
  /// edges. About 3 for steps, 1 for edges much wider than both blurs. 0 when no direction has enough edges; such an
  /// image does not count as blurred.
  double sharpness = 0.0;
  /// That direction, which is the direction of a smear, in [0, 180): 0 = along the rows, 90 = along the columns. In
  /// steps of 22.5.
  double direction_deg = 0.0;
  /// How many of the 8 directions had enough edges across them.
  int num_directions = 0;
};

/// Is the image smeared by motion, or out of focus? The histogram is equalised first, so that one threshold fits dark
/// and bright images (Section III of the paper), with limited contrast. Across an edge of width s (standard deviation)
/// a Gaussian of sigma leaves a gradient of contrast / sqrt(2 pi (s^2 + sigma^2)); the ratio at a fine and a coarse
/// sigma depends on s alone, not on contrast. A smear blurs the edges across its direction and those up to 45 degrees
/// from it, and leaves the others sharp: each direction is judged by all edges within 45 degrees, and the least sharp
/// one decides. Only strong edges count, and of these the upper quantile: mottled plaster, shading and soft shadows are
/// wide in sharp images too, so they condemn none as long as there are sharp edges beside them.
///
/// Throws Error for options out of range. Linear in the pixels.
BlurResult measure_blur(const GrayImage& image, const BlurOptions& options);

}  // namespace cpplus
