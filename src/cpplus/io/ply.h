#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/cloud_source.h"
#include "cpplus/io/cloud_stream.h"
#include "cpplus/io/point_fields.h"

namespace cpplus {

/// A property of a PLY element: one number, or a list (its length as one number, then that many items).
struct PlyProperty {
  PointField field;                          // of a list: name and type of the items
  std::optional<ScalarType> list_size_type;  // set for a list
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding { kAscii, kLittleEndian, kBigEndian };

  Encoding encoding = Encoding::kAscii;
  std::vector<PlyElement> before_vertices;  // elements whose data comes first, to be skipped
  PlyElement vertices;
  std::vector<PointField> fields;  // the vertex properties that are no lists, with their roles
};

/// Reads and checks the header; the reader then stands at the data.
PlyHeader read_ply_header(BlockReader* reader);

/// Opens the vertices of ASCII and binary files of both byte orders; lists and other elements are skipped.
std::unique_ptr<CloudSource> open_ply(const std::string& path);

/// Writes binary little-endian PLY. Coordinates are float where the cloud's origin is zero, else double; then
/// "intensity", "red" "green" "blue", "timestamp", "num_views", "best_image" and "color_spread" where the cloud has
/// them.
void write_ply(const std::string& path, const CloudStream& cloud);

}  // namespace cpplus
