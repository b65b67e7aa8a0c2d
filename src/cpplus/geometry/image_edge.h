#pragma once

#include <Eigen/Core>
#include <vector>

namespace cpplus {

/// A point on an intensity edge of an image, in the pixels of the recorded (distorted) image.
struct ImageEdgel {
  Eigen::Vector2f pixel;   // sub-pixel position; centre of the top-left pixel = (0, 0)
  Eigen::Vector2f normal;  // unit, along the gradient (towards the brighter side)
  float gradient = 0.0f;   // magnitude, grey levels per pixel
};

/// All edgels of one image, in row-major order of the pixels they were found at.
struct ImageEdges {
  int width = 0;
  int height = 0;
  std::vector<ImageEdgel> edgels;
};

}  // namespace cpplus
