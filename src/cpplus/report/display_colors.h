#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

/// What the points of a cloud are shown in, in its order.
struct DisplayColors {
  std::vector<Rgb> colors;
  std::vector<uint8_t> is_colored;  // 0 where the colour is a grey that stands for none
};

/// The colours of the cloud. A point without one, because the cloud has none or no image sees it, is grey: lighter with
/// more intensity where the cloud has intensities.
DisplayColors display_colors(const PointCloud& cloud);

}  // namespace cpplus
