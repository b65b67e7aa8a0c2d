#pragma once

#include "cpplus/core/image.h"
#include "cpplus/geometry/image_edge.h"

namespace cpplus {

struct ImageEdgeOptions {
  /// Standard deviation of the Gaussian blur before the gradient, pixels. [0.5, 5]
  double sigma_px = 1.0;
  /// Share of the pixels whose gradient lies below the upper hysteresis threshold: the threshold follows the contrast
  /// of the image, within the limits of the next three. (0, 1)
  double strong_quantile = 0.85;
  /// The threshold is at least this many standard deviations of the noise in the gradient (in one direction), which is
  /// read from the smoothest fifth of the image: the noise of a dark, bare wall must not become edges. [0, inf)
  double noise_ratio = 5.0;
  /// Least and largest upper threshold, grey levels per pixel; the largest wins over the noise. [0.1, 127]
  double min_gradient = 1.0;
  double max_gradient = 10.0;
  /// Lower hysteresis threshold / upper one. (0, 1]
  double weak_ratio = 0.4;
  /// Edges whose 8-connected chain has fewer pixels are dropped as specks. [1, inf)
  int min_chain_px = 12;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("sigma_px", sigma_px, "Blur before the gradient, pixels. [0.5, 5]");
    visitor("strong_quantile", strong_quantile, "Share of pixels below the upper gradient threshold. (0, 1)");
    visitor("noise_ratio", noise_ratio, "Least upper threshold, sigmas of the gradient's noise. [0, inf)");
    visitor("min_gradient", min_gradient, "Least upper threshold, grey levels per pixel. [0.1, 127]");
    visitor("max_gradient", max_gradient, "Largest upper threshold, grey levels per pixel. [min_gradient, 127]");
    visitor("weak_ratio", weak_ratio, "Lower gradient threshold / upper one. (0, 1]");
    visitor("min_chain_px", min_chain_px, "Shorter edge chains are dropped. [1, inf)");
  }
};

/// Edges of a grey image: Canny's detector (Canny 1986) on the blurred image, then for each edge pixel the position of
/// the gradient's maximum to a fraction of a pixel, and its direction. The profile of the gradient across a blurred
/// step is a Gaussian, so its logarithm is a parabola: a quadratic fitted to log |gradient| over 3x3 pixels has its
/// maximum along the gradient at the edge, without the pull towards the pixel centre that a quadratic through
/// |gradient| itself has.
///
/// Nothing is reported within 2 sigma_px + 1 of the border, where the blur lacks data. An empty image or one smaller
/// than that margin gives no edges. Throws Error for options out of range. Linear in the pixels.
ImageEdges detect_image_edges(const GrayImage& image, const ImageEdgeOptions& options);

}  // namespace cpplus
