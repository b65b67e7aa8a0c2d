#include "cpplus/pipeline/npz_writer.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>

#include "cpplus/io/atomic_file.h"

namespace cpplus {
namespace {

uint32_t crc32(const std::string& data) {
  static const std::array<uint32_t, 256> table = [] {
    std::array<uint32_t, 256> entries{};
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t c = i;
      for (int k = 0; k < 8; ++k) c = (c & 1u) ? 0xEDB88320u ^ (c >> 1) : c >> 1;
      entries[i] = c;
    }
    return entries;
  }();
  uint32_t crc = 0xFFFFFFFFu;
  for (const char byte : data) crc = table[(crc ^ static_cast<uint8_t>(byte)) & 0xFFu] ^ (crc >> 8);
  return ~crc;
}

void put(std::string* out, uint64_t value, int num_bytes) {
  for (int i = 0; i < num_bytes; ++i) out->push_back(static_cast<char>((value >> (8 * i)) & 0xFFu));
}

/// NPY format 1.0: magic, header length, a Python dictionary padded to 64 bytes, the data.
std::string npy_bytes(const NpyArray& array) {
  std::string shape = "(";
  for (const size_t extent : array.shape) shape += fmt::format("{}, ", extent);
  if (array.shape.size() > 1) shape.resize(shape.size() - 2);
  if (array.shape.size() == 1) shape.pop_back();
  shape += ")";
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", array.type, shape);
  header.append(63 - (10 + header.size()) % 64, ' ');
  header.push_back('\n');
  std::string bytes = "\x93NUMPY";
  bytes.push_back(1);
  bytes.push_back(0);
  put(&bytes, header.size(), 2);
  bytes += header;
  bytes.append(array.bytes.begin(), array.bytes.end());
  return bytes;
}

/// The fields that a zip entry has in common in its local and central headers, from "version needed" on.
std::string zip_fields(const std::string& name, const std::string& data) {
  constexpr uint64_t kDate1980 = (1u << 5) | 1u;
  std::string out;
  put(&out, 20, 2);
  put(&out, 0, 2);  // flags
  put(&out, 0, 2);  // stored
  put(&out, 0, 2);  // time
  put(&out, kDate1980, 2);
  put(&out, crc32(data), 4);
  put(&out, data.size(), 4);
  put(&out, data.size(), 4);
  put(&out, name.size(), 2);
  put(&out, 0, 2);  // extra field
  return out;
}

}  // namespace

uint16_t to_half(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  const auto sign = static_cast<uint16_t>((bits >> 16) & 0x8000u);
  const float magnitude = std::abs(value);
  if (std::isnan(value)) return static_cast<uint16_t>(sign | 0x7E00u);
  if (magnitude >= 65520.0f) return static_cast<uint16_t>(sign | 0x7C00u);
  if (magnitude < 0x1.0p-14f) {  // subnormal: multiples of 2^-24
    return static_cast<uint16_t>(sign | static_cast<uint16_t>(std::nearbyint(magnitude * 0x1.0p24f)));
  }
  // Adding half a unit in the last place minus one, plus the last kept bit, rounds to nearest even.
  const uint32_t rounded = (bits & 0x7FFFFFFFu) + 0xFFFu + ((bits >> 13) & 1u);
  return static_cast<uint16_t>(sign | static_cast<uint16_t>((rounded >> 13) - (112u << 10)));
}

NpyArray half_array(const std::string& name, const std::vector<float>& values, const std::vector<size_t>& shape) {
  NpyArray array{name, "<f2", shape, {}};
  array.bytes.reserve(2 * values.size());
  for (const float value : values) {
    const uint16_t half = to_half(value);
    array.bytes.push_back(static_cast<uint8_t>(half & 0xFFu));
    array.bytes.push_back(static_cast<uint8_t>(half >> 8));
  }
  return array;
}

NpyArray int64_scalar(const std::string& name, int64_t value) {
  NpyArray array{name, "<i8", {}, {}};
  for (int i = 0; i < 8; ++i) array.bytes.push_back(static_cast<uint8_t>(static_cast<uint64_t>(value) >> (8 * i)));
  return array;
}

void write_npz(const std::string& path, const std::vector<NpyArray>& arrays) {
  std::string archive;
  std::string directory;
  for (const NpyArray& array : arrays) {
    const std::string name = array.name + ".npy";
    const std::string data = npy_bytes(array);
    const std::string fields = zip_fields(name, data);
    const size_t offset = archive.size();
    put(&archive, 0x04034B50u, 4);
    archive += fields + name + data;
    put(&directory, 0x02014B50u, 4);
    put(&directory, 20, 2);  // made by
    directory += fields;
    put(&directory, 0, 2);  // comment
    put(&directory, 0, 2);  // disk
    put(&directory, 0, 2);  // internal attributes
    put(&directory, 0, 4);  // external attributes
    put(&directory, offset, 4);
    directory += name;
  }
  const size_t directory_offset = archive.size();
  archive += directory;
  put(&archive, 0x06054B50u, 4);
  put(&archive, 0, 4);  // disks
  put(&archive, arrays.size(), 2);
  put(&archive, arrays.size(), 2);
  put(&archive, directory.size(), 4);
  put(&archive, directory_offset, 4);
  put(&archive, 0, 2);  // comment
  write_text_file(path, archive);
}

}  // namespace cpplus
