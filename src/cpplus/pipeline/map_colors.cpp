#include "cpplus/pipeline/map_colors.h"

namespace cpplus {

std::vector<ColoredPoint> MapColors::of_root(uint32_t root) const {
  ColorSamples of_points = samples->read(root);
  of_points.renumber_images(image_of_sample);
  return color_points(of_points, correction, images, max_deviation);
}

}  // namespace cpplus
