#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cpplus {

/// One array of a NumPy .npz archive.
struct NpyArray {
  std::string name;            // without .npy
  std::string type;            // NumPy's, e.g. "<f2", "<i8"
  std::vector<size_t> shape;   // empty = a single number
  std::vector<uint8_t> bytes;  // little-endian, row-major
};

/// IEEE half precision, rounded to nearest even; beyond its range it becomes infinite.
uint16_t to_half(float value);

NpyArray half_array(const std::string& name, const std::vector<float>& values, const std::vector<size_t>& shape);
NpyArray int64_scalar(const std::string& name, int64_t value);

/// Writes the arrays as numpy.savez does (uncompressed), through a temporary file.
void write_npz(const std::string& path, const std::vector<NpyArray>& arrays);

}  // namespace cpplus
