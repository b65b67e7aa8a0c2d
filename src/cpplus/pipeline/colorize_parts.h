#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/point_map.h"
#include "cpplus/colorize/colorize.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/pipeline/map_colors.h"

namespace cpplus {

/// The images that may give colours.
struct ColorImages {
  const SparseModel& model;
  const std::vector<size_t>& indices;  // into model.images
  /// The view of model.images[index]; nothing, for good, where the image cannot be used.
  std::function<std::optional<ColorView>(size_t index)> read;
};

struct PartsColorized {
  ColorizeResult result;     // without the cloud
  std::vector<size_t> used;  // images that gave colours, indices into the model's
  MapColors colors;
};

/// Colours the points in some roots (ascending) as colorize() does, taking samples from the images for at most
/// max_part_points points at a time (cloud/map_tiles.h). An image is read once for each such part that it can look at.
/// The result is the same for any parts. Samples lie in a temporary file for `target`. Throws Error where that cannot
/// be written, and naming the file `path` of the map where its indices are damaged.
PartsColorized colorize_in_parts(const std::string& path, const PointMap& points, std::vector<uint32_t> roots,
                                 const ColorImages& images, const ColorizeOptions& options, size_t max_part_points,
                                 const std::string& target);

}  // namespace cpplus
