#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/features/image_gradient.h"

namespace cpplus {

/// A pixel where the gradient has a maximum across the edge.
struct EdgePixel {
  int x = 0;
  int y = 0;
  uint32_t chain = 0;  // id of the 8-connected set of pixels that it belongs to
};

/// Edge pixels in row-major order, in chains.
struct EdgeChains {
  std::vector<EdgePixel> pixels;
  std::vector<uint32_t> sizes;  // pixels by chain
};

/// Canny's edge pixels (1986): maxima of the squared gradient across the edge above `weak`, in chains with one above
/// `strong` (both in units of the gradient). The maxima are told by the gradient's octant, as OpenCV does with its L2
/// gradient, and are the same pixels; here the chains are followed in the same pass. Gradients below 2^14.
EdgeChains find_edge_chains(const ImageGradient& gradient, double weak, double strong);

}  // namespace cpplus
