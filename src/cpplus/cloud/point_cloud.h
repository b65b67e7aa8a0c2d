#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// Points of one frame (usually the map) as a structure of arrays. The position of point i in the frame is
/// origin + positions[i]: the double origin keeps georeferenced (UTM) coordinates exact to float32 of the offsets.
/// Each attribute array is empty (the cloud does not have it) or as long as positions.
struct PointCloud {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // metres
  std::vector<Eigen::Vector3f> positions;            // metres, relative to origin
  std::vector<float> intensities;                    // the file's own unit
  std::vector<Rgb> colors;
  std::vector<double> stamps_s;
  std::vector<uint16_t> num_views;  // how many images gave a point its colour; 0 = no image sees it

  size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  Eigen::Vector3d point(size_t i) const { return origin + positions[i].cast<double>(); }
};

}  // namespace cpplus
