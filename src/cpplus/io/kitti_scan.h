#pragma once

#include <string>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

/// Reads a KITTI scan (.bin): x y z reflectance as float32, one after the other. Points that are not finite are
/// dropped. Throws Error for a file that is not whole or holds no points.
PointCloud read_kitti_scan(const std::string& path);

}  // namespace cpplus
