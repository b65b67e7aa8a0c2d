#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace cpplus {

/// A NumPy array, whatever its number type, in C (row-major) order.
struct NpyArray {
  std::vector<size_t> shape;   // empty for a scalar
  std::vector<double> values;  // product of shape
};

/// Reads the arrays of an .npz file (a zip archive of .npy files, stored or deflated) by their names without ".npy".
/// Number types: little-endian float16/32/64 and signed or unsigned integers.
/// Throws Error naming the file, and the array where the fault is inside one: not a zip archive, truncated, damaged
/// (checksum), unsupported compression or number type, Fortran order.
std::map<std::string, NpyArray> read_npz(const std::string& path);

}  // namespace cpplus
