#pragma once

#include "cpplus/core/image.h"

namespace cpplus {

struct BlurOptions {
  /// An image is blurred when its sharpness (see BlurResult) is below this. Sharp images have 2.3 and more, smears of
  /// 12 pixels at most 1.9, of 8 pixels about 1.75 (docs/image_edges.md). [1, 3]
  double min_sharpness = 2.1;
  /// The longer side of the image is first reduced to at most this, pixels: large sensors are soft at the scale of
  /// single pixels without being blurred. [64, inf)
  int max_size_px = 1280;
  /// An orientation with fewer strong edge pixels does not take part in the verdict. [1, inf)
  int min_edges = 60;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("min_sharpness", min_sharpness, "Images of less sharpness count as blurred. [1, 3]");
    visitor("max_size_px", max_size_px, "The blur is measured on an image reduced to this size. [64, inf)");
    visitor("min_edges", min_edges, "Edge pixels an orientation needs to take part. [1, inf)");
  }
};

struct BlurResult {
  bool blurred = false;
  /// Of the least sharp orientation: gradient after a fine blur / gradient after a three times coarser one, across
  /// strong edges. About 3 for steps, 1 for edges much wider than both blurs. 0 when no orientation has enough edges;
  /// such an image does not count as blurred.
  double sharpness = 0.0;
  /// Orientation of the gradient across the least sharp edges, which is the direction of a smear, in [0, 180): 0 =
  /// along the rows, 90 = along the columns. In steps of 22.5.
  double direction_deg = 0.0;
  /// How many of the 8 orientations had enough edges.
  int num_orientations = 0;
};

/// Is the image smeared by motion, or out of focus? The histogram is equalised first, so that one threshold fits dark
/// and bright images (Section III of the paper), with limited contrast. Across an edge of width s (standard deviation)
/// a Gaussian of sigma leaves a gradient of contrast / sqrt(2 pi (s^2 + sigma^2)); the ratio at a fine and a coarse
/// sigma depends on s alone, not on contrast. A smear blurs only the edges across its direction, hence each orientation
/// is judged by itself, from its own strongest edges, and the least sharp one decides. Within an orientation the upper
/// quantile counts: soft shadows do not make an image blurred as long as there are sharp edges beside them.
///
/// Throws Error for options out of range. Linear in the pixels.
BlurResult measure_blur(const GrayImage& image, const BlurOptions& options);

}  // namespace cpplus
