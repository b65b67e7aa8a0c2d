#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/point_fields.h"

namespace cpplus {

/// What the header and the variable length records of a LAS file say (ASPRS LAS 1.2 to 1.4).
struct LasHeader {
  int version_minor = 4;
  int point_format = 0;  // 0-3, 6-8
  uint64_t num_points = 0;
  size_t record_size = 0;                         // bytes
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  // metres, as announced
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  LasFrame frame;
  std::vector<PointField> fields;  // those that a PointCloud keeps
};

/// Reads and checks the header; the reader then stands at the first point. Throws Error naming the file and the value
/// for anything that cannot be: another version or point format, compressed points (LAZ), a header, record or scale
/// of an impossible size, more points than the file has room for.
LasHeader read_las_header(BlockReader* reader);

/// Size of a point record without extra bytes; 0 for formats that are not supported.
size_t las_record_size(int point_format);
/// Offset of time and colour in a record; 0 where the format has none.
size_t las_stamp_offset(int point_format);
size_t las_color_offset(int point_format);

}  // namespace cpplus
