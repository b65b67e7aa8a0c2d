#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cpplus/colorize/colorize.h"
#include "cpplus/pipeline/sample_file.h"

namespace cpplus {

/// The colours of the points in some roots of a map, found from their samples when they are asked for. Safe from
/// several threads.
struct MapColors {
  std::vector<uint32_t> roots;  // ascending
  std::unique_ptr<SampleFile> samples;
  std::vector<uint16_t> image_of_sample;  // into `images`, by the images of the samples
  std::vector<ColorizedImage> images;
  ExposureCorrection correction;
  double max_deviation = 0.0;  // see robust_color

  /// Those of the points of a root, in map order; empty for another root.
  std::vector<ColoredPoint> of_root(uint32_t root) const;
};

}  // namespace cpplus
