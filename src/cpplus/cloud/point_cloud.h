#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// A variable length record of a LAS file, kept as it is.
struct LasRecord {
  std::string user_id;
  uint16_t record_id = 0;
  std::string description;
  std::vector<uint8_t> content;
};

/// The grid and the coordinate system of the LAS file that a cloud came from, so that it can be written back onto them:
/// a coordinate in the file is an integer, integer * scale + offset metres.
struct LasFrame {
  Eigen::Vector3d scale = Eigen::Vector3d::Constant(1e-3);
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  uint16_t global_encoding = 0;       // its bits for the kind of GPS time and of coordinate system
  std::vector<LasRecord> projection;  // the coordinate system's records (WKT or GeoTIFF keys)
};

/// Points of one frame (usually the map) as a structure of arrays. The position of point i in the frame is
/// origin + positions[i]: the double origin keeps georeferenced (UTM) coordinates exact to float32 of the offsets.
/// Each attribute array is empty (the cloud does not have it) or as long as positions.
struct PointCloud {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // metres
  std::vector<Eigen::Vector3f> positions;            // metres, relative to origin
  std::vector<float> intensities;                    // the file's own unit
  std::vector<Rgb> colors;
  std::vector<double> stamps_s;
  std::vector<uint16_t> num_views;     // how many images gave a point its colour; 0 = no image sees it
  std::vector<uint32_t> best_images;   // model's id of the image that counts most; 0 where no image sees it
  std::vector<uint8_t> color_spreads;  // how far the images disagree on the colour, RMS in grey levels
  std::optional<LasFrame> las_frame;

  size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  Eigen::Vector3d point(size_t i) const { return origin + positions[i].cast<double>(); }
};

}  // namespace cpplus
