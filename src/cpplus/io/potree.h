#pragma once

#include <string>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/point_octree.h"

namespace cpplus {

/// Writes the cloud and its octree as a Potree 2.0 point cloud: FOLDER/octree.bin, hierarchy.bin (one chunk) and
/// metadata.json with the encoding DEFAULT. Positions are 32-bit steps of the octree; attributes are those that the
/// cloud has: intensity (16 bits, IntensityFactor), rgb (3 x 16 bits, 257 times the colours), num_views, best_image
/// and color_spread. `name` is the one in metadata.json. Throws Error where a file cannot be written.
void write_potree(const std::string& folder, const std::string& name, const PointCloud& cloud,
                  const PointOctree& octree);

}  // namespace cpplus
