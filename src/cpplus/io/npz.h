#pragma once

#include <string>

#include "cpplus/core/image.h"

namespace cpplus {

/// Reads one two-dimensional float16 or float32 array out of a NumPy .npz archive (stored or deflated). Throws Error
/// naming file and array when it is missing, of another type or shape, or the archive is damaged.
Image<float> read_npz_image(const std::string& path, const std::string& array_name);

/// The array "range": exact depth along the viewing rays, metres, 0 = nothing there.
RangeImage read_npz_range(const std::string& path);

/// IEEE 754 half to single precision.
float half_to_float(uint16_t half);

}  // namespace cpplus
