#pragma once

#include "cpplus/core/image.h"

namespace cpplus {

/// The factor, at most 1, by which an image is made smaller so that its longer side has at most max_side_px pixels.
double shrink_factor(int width, int height, int max_side_px);

/// The image in the size of scaled_camera(camera, factor) (geometry/scaled_camera.h); pixels are averaged.
ColorImage shrink_image(const ColorImage& image, double factor);

}  // namespace cpplus
