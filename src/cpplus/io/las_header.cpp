#include "cpplus/io/las_header.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <string>

#include "cpplus/core/error.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

constexpr size_t kRecordHeaderSize = 54;      // of a variable length record
constexpr size_t kExtraBytesEntrySize = 192;  // of the record that describes extra bytes
constexpr uint16_t kExtraBytesRecordId = 4;
// Bits of the global encoding that say how to read what we keep: kind of GPS time, coordinate system as WKT.
constexpr uint16_t kKeptEncodingBits = 0x11;

template <typename T>
T load(const uint8_t* data, size_t offset) {
  T value;
  std::memcpy(&value, data + offset, sizeof(T));
  return value;
}

std::string load_text(const uint8_t* data, size_t size) {
  const char* text = reinterpret_cast<const char*>(data);
  return {text, strnlen(text, size)};
}

ScalarType extra_bytes_type(int data_type) {
  constexpr ScalarType kTypes[] = {ScalarType::kUint8,   ScalarType::kInt8,   ScalarType::kUint16, ScalarType::kInt16,
                                   ScalarType::kUint32,  ScalarType::kInt32,  ScalarType::kUint64, ScalarType::kInt64,
                                   ScalarType::kFloat32, ScalarType::kFloat64};
  return kTypes[data_type - 1];
}

PointRole extra_bytes_role(const std::string& name) {
  if (name == "num_views") return PointRole::kNumViews;
  if (name == "best_image") return PointRole::kBestImage;
  return name == "color_spread" ? PointRole::kColorSpread : PointRole::kNone;
}

/// Looks for the extra bytes that write_las adds.
void add_extra_fields(const std::vector<uint8_t>& entries, LasHeader* header) {
  size_t offset = las_record_size(header->point_format);
  for (size_t i = 0; i + kExtraBytesEntrySize <= entries.size(); i += kExtraBytesEntrySize) {
    const int data_type = entries[i + 2];
    constexpr int kLargestType = 10;
    if (data_type > kLargestType) return;  // arrays, deprecated: their successors' offsets cannot be trusted
    if (data_type == 0) {
      offset += entries[i + 3];  // undocumented bytes, as many as the options say
      continue;
    }
    const ScalarType type = extra_bytes_type(data_type);
    const std::string name = load_text(&entries[i + 4], 32);
    const PointRole role = extra_bytes_role(name);
    if (role != PointRole::kNone && offset + scalar_size(type) <= header->record_size) {
      header->fields.push_back({name, type, 1, offset, role});
    }
    offset += scalar_size(type);
  }
}

void read_records(BlockReader* reader, uint32_t num_records, uint64_t points_offset, LasHeader* header) {
  for (uint32_t i = 0; i < num_records; ++i) {
    if (reader->position() + kRecordHeaderSize > points_offset) {
      throw Error(fmt::format("{}: {} variable length records do not fit before the points at offset {}",
                              reader->path(), num_records, points_offset));
    }
    const uint8_t* data = reader->take(kRecordHeaderSize);
    LasRecord record;
    record.user_id = load_text(data + 2, 16);
    record.record_id = load<uint16_t>(data, 18);
    const uint16_t size = load<uint16_t>(data, 20);
    record.description = load_text(data + 22, 32);
    if (reader->position() + size > points_offset) {
      throw Error(fmt::format("{}: variable length record {} of {} bytes runs into the points at offset {}",
                              reader->path(), i, size, points_offset));
    }
    const uint8_t* content = reader->take(size);
    record.content.assign(content, content + size);
    if (record.user_id == "LASF_Projection") {
      header->frame.projection.push_back(std::move(record));
    } else if (record.user_id == "LASF_Spec" && record.record_id == kExtraBytesRecordId) {
      add_extra_fields(record.content, header);
    }
  }
}

void add_standard_fields(LasHeader* header) {
  header->fields = {{"X", ScalarType::kInt32, 1, 0, PointRole::kX},
                    {"Y", ScalarType::kInt32, 1, 4, PointRole::kY},
                    {"Z", ScalarType::kInt32, 1, 8, PointRole::kZ},
                    {"intensity", ScalarType::kUint16, 1, 12, PointRole::kIntensity}};
  if (const size_t offset = las_stamp_offset(header->point_format); offset > 0) {
    header->fields.push_back({"gps_time", ScalarType::kFloat64, 1, offset, PointRole::kStamp});
  }
  if (const size_t offset = las_color_offset(header->point_format); offset > 0) {
    header->fields.push_back({"red", ScalarType::kUint16, 1, offset, PointRole::kRed});
    header->fields.push_back({"green", ScalarType::kUint16, 1, offset + 2, PointRole::kGreen});
    header->fields.push_back({"blue", ScalarType::kUint16, 1, offset + 4, PointRole::kBlue});
  }
}

void check_frame(const std::string& path, const LasFrame& frame) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(frame.scale[axis]) || frame.scale[axis] <= 0.0) {
      throw Error(fmt::format("{}: LAS header: {} scale {} is not positive", path, "xyz"[axis], frame.scale[axis]));
    }
    if (!std::isfinite(frame.offset[axis])) {
      throw Error(fmt::format("{}: LAS header: {} offset {} is not finite", path, "xyz"[axis], frame.offset[axis]));
    }
  }
}

/// The bytes of the header, whose size and the place of the points have been checked.
std::vector<uint8_t> read_fixed_part(BlockReader* reader) {
  const std::string& path = reader->path();
  constexpr size_t kCommonSize = 227;
  if (reader->file_size() < kCommonSize) {
    throw Error(fmt::format("{}: truncated: {} bytes are too few for a LAS header", path, reader->file_size()));
  }
  const uint8_t* common = reader->take(kCommonSize);
  std::vector<uint8_t> data(common, common + kCommonSize);
  if (std::memcmp(data.data(), "LASF", 4) != 0) {
    throw Error(fmt::format("{}: not a LAS file: no LASF at its start", path));
  }
  const int major = data[24];
  const int minor = data[25];
  if (major != 1 || minor < 2 || minor > 4) {
    throw Error(fmt::format("{}: LAS version {}.{} is not supported (1.2 to 1.4 are)", path, major, minor));
  }
  constexpr size_t kHeaderSizes[] = {227, 235, 375};
  const size_t smallest_size = kHeaderSizes[minor - 2];
  const uint16_t size = load<uint16_t>(data.data(), 94);
  const uint32_t points_offset = load<uint32_t>(data.data(), 96);
  if (size < smallest_size) {
    throw Error(
        fmt::format("{}: LAS header size {} is less than the {} of version 1.{}", path, size, smallest_size, minor));
  }
  if (points_offset < size || points_offset > reader->file_size()) {
    throw Error(fmt::format("{}: LAS header: points at offset {} with a header of {} and a file of {} bytes", path,
                            points_offset, size, reader->file_size()));
  }
  const uint8_t* rest = reader->take(size - kCommonSize);
  data.insert(data.end(), rest, rest + (size - kCommonSize));
  return data;
}

void read_point_layout(const BlockReader& reader, const std::vector<uint8_t>& data, LasHeader* header) {
  const std::string& path = reader.path();
  header->point_format = data[104];
  constexpr int kCompressedBits = 0xC0;
  if ((header->point_format & kCompressedBits) != 0) {
    throw Error(fmt::format("{}: its points are LAZ-compressed, which is not supported: decompress it to LAS", path));
  }
  header->record_size = load<uint16_t>(data.data(), 105);
  const size_t smallest_record = las_record_size(header->point_format);
  if (smallest_record == 0) {
    throw Error(fmt::format("{}: LAS point format {} is not supported (0-3 and 6-8 are)", path, header->point_format));
  }
  if (header->record_size < smallest_record) {
    throw Error(fmt::format("{}: LAS header: records of {} bytes are too short for point format {} ({} bytes)", path,
                            header->record_size, header->point_format, smallest_record));
  }
  header->num_points = load<uint32_t>(data.data(), 107);
  constexpr size_t kCountOffset = 247;
  if (header->version_minor == 4 && load<uint64_t>(data.data(), kCountOffset) > 0) {
    header->num_points = load<uint64_t>(data.data(), kCountOffset);
  }
  const uint64_t available = reader.file_size() - load<uint32_t>(data.data(), 96);
  if (header->num_points > available / header->record_size) {
    throw Error(fmt::format("{}: truncated: {} points of {} bytes do not fit into the {} bytes after the header", path,
                            header->num_points, header->record_size, available));
  }
}

}  // namespace

size_t las_record_size(int point_format) {
  constexpr size_t kSizes[] = {20, 28, 26, 34, 0, 0, 30, 36, 38};
  return point_format >= 0 && point_format <= 8 ? kSizes[point_format] : 0;
}

size_t las_stamp_offset(int point_format) {
  if (point_format == 1 || point_format == 3) return 20;
  return point_format >= 6 ? 22 : 0;
}

size_t las_color_offset(int point_format) {
  constexpr size_t kOffsets[] = {0, 0, 20, 28, 0, 0, 0, 30, 30};
  return kOffsets[point_format];
}

LasHeader read_las_header(BlockReader* reader) {
  const std::vector<uint8_t> data = read_fixed_part(reader);
  const uint32_t points_offset = load<uint32_t>(data.data(), 96);
  LasHeader header;
  header.version_minor = data[25];
  read_point_layout(*reader, data, &header);
  for (size_t i = 0; i < 3; ++i) {
    const int axis = static_cast<int>(i);
    header.frame.scale[axis] = load<double>(data.data(), 131 + 8 * i);
    header.frame.offset[axis] = load<double>(data.data(), 155 + 8 * i);
    header.max[axis] = load<double>(data.data(), 179 + 16 * i);
    header.min[axis] = load<double>(data.data(), 187 + 16 * i);
  }
  header.frame.global_encoding = load<uint16_t>(data.data(), 6) & kKeptEncodingBits;
  check_frame(reader->path(), header.frame);
  add_standard_fields(&header);
  read_records(reader, load<uint32_t>(data.data(), 100), points_offset, &header);
  reader->skip(points_offset - reader->position());
  return header;
}

}  // namespace cpplus
