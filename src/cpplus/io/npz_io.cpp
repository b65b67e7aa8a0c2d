#include "cpplus/io/npz_io.h"

#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

template <typename Number>
Number little_endian(const std::string& bytes, size_t offset) {
  static_assert(std::endian::native == std::endian::little);
  if (offset + sizeof(Number) > bytes.size()) throw Error("truncated");
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof(Number));
  return number;
}

std::string slice(const std::string& bytes, size_t offset, size_t size) {
  if (offset > bytes.size() || size > bytes.size() - offset) throw Error("truncated");
  return bytes.substr(offset, size);
}

std::string inflate_raw(const std::string& compressed, size_t size) {
  // Deflate cannot shrink by more than about 1032: a larger size is a damaged header, not a reason to allocate.
  if (size / 1040 > compressed.size()) throw Error(fmt::format("impossible size {}", size));
  std::string bytes(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw Error("zlib cannot be initialised");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(compressed.data()));
  stream.avail_in = static_cast<uInt>(compressed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(size);
  const int status = inflate(&stream, Z_FINISH);
  const bool whole = status == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  if (!whole) throw Error("damaged compressed data");
  return bytes;
}

struct ZipEntry {
  std::string name;
  uint16_t method;
  uint32_t crc;
  uint32_t compressed_size;
  uint32_t size;
  uint32_t local_header;
};

/// The central directory (APPNOTE 4.3.12, 4.3.16); without zip64, which only files above 4 GB need.
std::vector<ZipEntry> list_zip(const std::string& archive) {
  const size_t end = archive.rfind("PK\x05\x06");
  if (end == std::string::npos) throw Error("not a zip archive, or truncated");
  const auto count = little_endian<uint16_t>(archive, end + 10);
  size_t offset = little_endian<uint32_t>(archive, end + 16);
  std::vector<ZipEntry> entries;
  for (int i = 0; i < count; ++i) {
    if (slice(archive, offset, 4) != "PK\x01\x02") throw Error("damaged zip directory");
    const auto name_size = little_endian<uint16_t>(archive, offset + 28);
    entries.push_back({slice(archive, offset + 46, name_size), little_endian<uint16_t>(archive, offset + 10),
                       little_endian<uint32_t>(archive, offset + 16), little_endian<uint32_t>(archive, offset + 20),
                       little_endian<uint32_t>(archive, offset + 24), little_endian<uint32_t>(archive, offset + 42)});
    offset +=
        46u + name_size + little_endian<uint16_t>(archive, offset + 30) + little_endian<uint16_t>(archive, offset + 32);
  }
  return entries;
}

std::string unzip(const std::string& archive, const ZipEntry& entry) {
  const size_t local = entry.local_header;
  if (slice(archive, local, 4) != "PK\x03\x04") throw Error("damaged zip entry");
  const size_t begin =
      local + 30 + little_endian<uint16_t>(archive, local + 26) + little_endian<uint16_t>(archive, local + 28);
  std::string bytes = slice(archive, begin, entry.compressed_size);
  if (entry.method == 8) {
    bytes = inflate_raw(bytes, entry.size);
  } else if (entry.method != 0) {
    throw Error(fmt::format("unsupported zip compression {}", entry.method));
  }
  if (crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())) != entry.crc) {
    throw Error("checksum does not match");
  }
  return bytes;
}

double half_to_double(uint16_t bits) {
  const int exponent = (bits >> 10) & 31;
  const int mantissa = bits & 1023;
  double value = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
  if (exponent == 31) value = mantissa ? NAN : INFINITY;
  return bits & 0x8000 ? -value : value;
}

double read_number(const std::string& bytes, size_t offset, const std::string& type) {
  if (type == "<f2") return half_to_double(little_endian<uint16_t>(bytes, offset));
  if (type == "<f4") return little_endian<float>(bytes, offset);
  if (type == "<f8") return little_endian<double>(bytes, offset);
  if (type == "|i1") return little_endian<int8_t>(bytes, offset);
  if (type == "<i2") return little_endian<int16_t>(bytes, offset);
  if (type == "<i4") return little_endian<int32_t>(bytes, offset);
  if (type == "<i8") return static_cast<double>(little_endian<int64_t>(bytes, offset));
  if (type == "|u1" || type == "|b1") return little_endian<uint8_t>(bytes, offset);
  if (type == "<u2") return little_endian<uint16_t>(bytes, offset);
  if (type == "<u4") return little_endian<uint32_t>(bytes, offset);
  if (type == "<u8") return static_cast<double>(little_endian<uint64_t>(bytes, offset));
  throw Error(fmt::format("unsupported number type {}", type));
}

/// What follows 'key': in the header's Python dictionary, up to `stop`.
std::string header_value(const std::string& header, const std::string& key, char stop) {
  const size_t found = header.find("'" + key + "':");
  const size_t begin = found == std::string::npos ? found : header.find_first_not_of(" ('", found + key.size() + 3);
  const size_t end = begin == std::string::npos ? begin : header.find(stop, begin);
  if (end == std::string::npos) throw Error(fmt::format("no {} in the array's header", key));
  return header.substr(begin, end - begin);
}

NpyArray parse_npy(const std::string& bytes) {
  if (slice(bytes, 0, 6) != "\x93NUMPY") throw Error("not a NumPy array");
  const bool long_header = little_endian<uint8_t>(bytes, 6) > 1;
  const size_t header_begin = long_header ? 12 : 10;
  const size_t header_size = long_header ? little_endian<uint32_t>(bytes, 8) : little_endian<uint16_t>(bytes, 8);
  const std::string header = slice(bytes, header_begin, header_size);
  const std::string type = header_value(header, "descr", '\'');
  if (header_value(header, "fortran_order", ',') != "False") throw Error("Fortran order is not supported");

  NpyArray array;
  // "192, 256", "2,", or for a scalar ")" itself, which header_value finds as the empty text before it.
  std::string shape = header_value(header, "shape", ')');
  size_t count = 1;
  const size_t data_size = bytes.size() - header_begin - header_size;
  for (size_t at = shape.find_first_of("0123456789"); at != std::string::npos;) {
    const size_t stop = std::min(shape.find_first_not_of("0123456789", at), shape.size());
    if (stop - at > 12) throw Error(fmt::format("impossible shape ({})", shape));
    array.shape.push_back(std::stoul(shape.substr(at, stop - at)));
    count *= array.shape.back();
    if (count > data_size) throw Error(fmt::format("shape ({}) is larger than the data", shape));
    at = shape.find_first_of("0123456789", stop);
  }
  const size_t item_size = static_cast<size_t>(type.back() - '0');
  array.values.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    array.values.push_back(read_number(bytes, header_begin + header_size + i * item_size, type));
  }
  return array;
}

}  // namespace

std::map<std::string, NpyArray> read_npz(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(fmt::format("{}: cannot be opened", path));
  const std::string archive{std::istreambuf_iterator<char>(file), {}};
  std::map<std::string, NpyArray> arrays;
  std::string name;
  try {
    for (const ZipEntry& entry : list_zip(archive)) {
      name = entry.name.substr(0, entry.name.rfind(".npy"));
      arrays[name] = parse_npy(unzip(archive, entry));
    }
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}{}", path, name.empty() ? "" : "array " + name + ": ", error.what()));
  }
  return arrays;
}

}  // namespace cpplus
