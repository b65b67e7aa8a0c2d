#pragma once

#include "cpplus/cloud/depth_buffer.h"
#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/point_map.h"
#include "cpplus/colorize/gray_scale.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/pipeline/map_colors.h"

namespace cpplus {

/// A map with the colours that were found for some of its roots.
struct ColoredCloud {
  const PointMap& points;
  const MapColors& colors;
  const GrayScale& grays;  // of what no image shows
};

/// The points in the roots that have colours, as far as they are drawn in a picture (is_drawn), in the order of the
/// input: positions, colours and view counts. So one picture takes no more memory in a large map than in a small one.
PointCloud drawn_points(const ColoredCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map);

}  // namespace cpplus
