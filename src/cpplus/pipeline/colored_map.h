#pragma once

#include <string>

#include "cpplus/cloud/point_map.h"
#include "cpplus/colorize/gray_scale.h"
#include "cpplus/pipeline/map_colors.h"

namespace cpplus {

/// Writes all points of a map in the order of the input, in the format of the extension of `out`: with the colours,
/// view counts, best images and spreads of `colors`, and the grey of their intensity where no image shows them. The
/// map's other attributes stay. Memory does not grow with the map. Throws Error where `out` cannot be written, and
/// naming the file `path` of the map where its indices are damaged.
void write_colored_map(const std::string& path, const PointMap& points, const MapColors& colors, const GrayScale& grays,
                       const std::string& out);

}  // namespace cpplus
