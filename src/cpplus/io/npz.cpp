#include "cpplus/io/npz.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

/// A file of a zip archive, as its central directory has it.
struct ZipEntry {
  uint16_t method = 0;
  uint32_t checksum = 0;
  uint32_t packed_size = 0;
  uint32_t size = 0;
  uint32_t local_header = 0;  // offset
};

template <typename T>
T load(const std::vector<uint8_t>& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::vector<uint8_t> read_bytes(const std::string& path) {
  BlockReader reader(path);
  constexpr uint64_t kMaxSize = uint64_t{1} << 31;
  if (reader.file_size() > kMaxSize) throw Error(fmt::format("{}: {} bytes are too many", path, reader.file_size()));
  const uint8_t* data = reader.take(reader.file_size());
  return {data, data + reader.file_size()};
}

/// Looks the name up in the central directory, which the record at the end of the archive points to.
ZipEntry find_entry(const std::string& path, const std::vector<uint8_t>& archive, const std::string& name) {
  constexpr size_t kEndSize = 22, kDirectorySize = 46;
  constexpr uint32_t kEndSignature = 0x06054b50, kDirectorySignature = 0x02014b50;
  size_t end = archive.size();
  if (archive.size() >= kEndSize) {
    for (end = archive.size() - kEndSize; end > 0 && load<uint32_t>(archive, end) != kEndSignature; --end) continue;
  }
  if (archive.size() < kEndSize || load<uint32_t>(archive, end) != kEndSignature) {
    throw Error(fmt::format("{}: not a zip archive, or broken off ({} bytes)", path, archive.size()));
  }
  const uint16_t num_entries = load<uint16_t>(archive, end + 10);
  size_t offset = load<uint32_t>(archive, end + 16);
  for (uint16_t i = 0; i < num_entries; ++i) {
    if (offset + kDirectorySize > end || load<uint32_t>(archive, offset) != kDirectorySignature) break;
    const size_t name_size = load<uint16_t>(archive, offset + 28);
    const size_t other_size = size_t{load<uint16_t>(archive, offset + 30)} + load<uint16_t>(archive, offset + 32);
    if (offset + kDirectorySize + name_size > end) break;
    if (std::string_view(reinterpret_cast<const char*>(&archive[offset + kDirectorySize]), name_size) == name) {
      return {load<uint16_t>(archive, offset + 10), load<uint32_t>(archive, offset + 16),
              load<uint32_t>(archive, offset + 20), load<uint32_t>(archive, offset + 24),
              load<uint32_t>(archive, offset + 42)};
    }
    offset += kDirectorySize + name_size + other_size;
  }
  throw Error(fmt::format("{}: holds no array {}", path, name));
}

/// Inflates raw deflate data; false when it is damaged or of another size.
bool inflate_bytes(const uint8_t* packed, uint32_t packed_size, std::vector<uint8_t>* bytes) {
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return false;
  stream.next_in = const_cast<uint8_t*>(packed);
  stream.avail_in = packed_size;
  stream.next_out = bytes->data();
  stream.avail_out = static_cast<uInt>(bytes->size());
  const int status = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  return status == Z_STREAM_END && stream.avail_out == 0;
}

std::vector<uint8_t> unpack(const std::string& path, const std::vector<uint8_t>& archive, const std::string& name) {
  const ZipEntry entry = find_entry(path, archive, name);
  constexpr size_t kLocalSize = 30;
  // Deflate expands at most 1032 times: a larger size is a lie that must not reserve memory.
  constexpr uint64_t kMaxExpansion = 1032;
  const auto fail = [&]() { throw Error(fmt::format("{}: array {} is damaged", path, name)); };
  if (entry.local_header + kLocalSize > archive.size()) fail();
  const size_t data = entry.local_header + kLocalSize + load<uint16_t>(archive, entry.local_header + 26) +
                      load<uint16_t>(archive, entry.local_header + 28);
  if (data + entry.packed_size > archive.size() || entry.size > kMaxExpansion * entry.packed_size) fail();
  std::vector<uint8_t> bytes;
  constexpr int kStored = 0, kDeflated = 8;
  if (entry.method == kStored) {
    bytes.assign(archive.begin() + static_cast<std::ptrdiff_t>(data),
                 archive.begin() + static_cast<std::ptrdiff_t>(data + entry.packed_size));
  } else if (entry.method == kDeflated) {
    bytes.resize(entry.size);
    if (!inflate_bytes(&archive[data], entry.packed_size, &bytes)) fail();
  } else {
    throw Error(fmt::format("{}: array {} is packed with method {}, which is not supported", path, name, entry.method));
  }
  if (crc32(0, bytes.data(), static_cast<uInt>(bytes.size())) != entry.checksum) fail();
  return bytes;
}

/// The part of a .npy header that follows "'key': ", up to the next comma outside brackets.
std::string_view header_value(std::string_view header, const std::string& key) {
  const size_t at = header.find("'" + key + "':");
  if (at == std::string_view::npos) return {};
  std::string_view value = header.substr(at + key.size() + 3);
  const size_t open = value.find_first_of("(,");
  const bool is_tuple = open != std::string_view::npos && value[open] == '(';
  return trim(value.substr(0, is_tuple ? value.find(')') + 1 : open));
}

struct NpyHeader {
  std::string type;
  int width = 0;
  int height = 0;
  size_t data_offset = 0;
};

NpyHeader parse_npy_header(const std::string& where, const std::vector<uint8_t>& bytes) {
  constexpr size_t kPrefix = 10;
  if (bytes.size() < kPrefix || std::memcmp(bytes.data(), "\x93NUMPY\x01", 7) != 0) {
    throw Error(fmt::format("{}: not a NumPy array of format version 1", where));
  }
  NpyHeader header;
  header.data_offset = kPrefix + load<uint16_t>(bytes, 8);
  if (header.data_offset > bytes.size()) throw Error(fmt::format("{}: its header is broken off", where));
  const std::string_view text(reinterpret_cast<const char*>(&bytes[kPrefix]), header.data_offset - kPrefix);
  header.type = header_value(text, "descr");
  if (header_value(text, "fortran_order") != "False") throw Error(fmt::format("{}: is not in row order", where));
  const std::string_view shape = header_value(text, "shape");
  const size_t comma = shape.find(',');
  std::optional<uint64_t> height, width;
  if (comma != std::string_view::npos && shape.size() > comma + 2) {
    height = parse_uint(trim(shape.substr(1, comma - 1)));
    width = parse_uint(trim(shape.substr(comma + 1, shape.size() - comma - 2)));
  }
  constexpr uint64_t kMaxSide = 1 << 20;
  if (!height || !width || *height > kMaxSide || *width > kMaxSide) {
    throw Error(fmt::format("{}: its shape is {}, not two-dimensional", where, in_quotes(shape)));
  }
  header.height = static_cast<int>(*height);
  header.width = static_cast<int>(*width);
  return header;
}

}  // namespace

float half_to_float(uint16_t half) {
  const int exponent = half >> 10 & 31;
  const int mantissa = half & 1023;
  float magnitude = 0.0f;
  if (exponent == 31) {
    magnitude = mantissa == 0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
  } else if (exponent == 0) {
    magnitude = std::ldexp(static_cast<float>(mantissa), -24);
  } else {
    magnitude = std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25);
  }
  return (half & 0x8000) != 0 ? -magnitude : magnitude;
}

Image<float> read_npz_image(const std::string& path, const std::string& array_name) {
  const std::string where = fmt::format("{}: array {}", path, array_name);
  const std::vector<uint8_t> bytes = unpack(path, read_bytes(path), array_name + ".npy");
  const NpyHeader header = parse_npy_header(where, bytes);
  const bool is_half = header.type == "'<f2'";
  if (!is_half && header.type != "'<f4'") {
    throw Error(fmt::format("{}: its type is {}, not float16 or float32", where, header.type));
  }
  const size_t num_pixels = static_cast<size_t>(header.width) * static_cast<size_t>(header.height);
  if ((bytes.size() - header.data_offset) != num_pixels * (is_half ? sizeof(uint16_t) : sizeof(float))) {
    throw Error(fmt::format("{}: {} bytes for a shape of {} x {}", where, bytes.size() - header.data_offset,
                            header.height, header.width));
  }
  Image<float> image(header.width, header.height);
  for (size_t i = 0; i < num_pixels; ++i) {
    image.pixels[i] = is_half ? half_to_float(load<uint16_t>(bytes, header.data_offset + sizeof(uint16_t) * i))
                              : load<float>(bytes, header.data_offset + sizeof(float) * i);
  }
  return image;
}

RangeImage read_npz_range(const std::string& path) { return read_npz_image(path, "range"); }

}  // namespace cpplus
