#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/cloud_source.h"
#include "cpplus/io/cloud_stream.h"
#include "cpplus/io/point_fields.h"

namespace cpplus {

/// The header of a PCD file (Point Cloud Data, version 0.6 and 0.7).
struct PcdHeader {
  enum class Encoding { kAscii, kBinary, kBinaryCompressed };

  std::vector<PointField> fields;
  size_t num_points = 0;
  size_t record_size = 0;  // bytes
  Encoding encoding = Encoding::kAscii;
};

/// Reads and checks the header; the reader then stands at the data.
PcdHeader read_pcd_header(BlockReader* reader);

/// Opens all three encodings, any field order, types and padding. The VIEWPOINT is ignored: coordinates are taken as
/// they are.
std::unique_ptr<CloudSource> open_pcd(const std::string& path);

/// Writes PCD 0.7 binary. Coordinates are float32 where the cloud's origin is zero, else float64; colour is PCL's
/// packed "rgb", the stamp a float64 "timestamp", the number of views a uint16 "num_views",
/// the best image a uint32 "best_image", the spread of the colour a uint8 "color_spread".
void write_pcd(const std::string& path, const CloudStream& cloud);

}  // namespace cpplus
