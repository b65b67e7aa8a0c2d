#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

#include "cpplus/core/image.h"

namespace cpplus {

using DeepImage = Image<uint16_t>;
using DeepColorImage = Image<std::array<uint16_t, 3>>;

/// 16-bit PNG of one channel, or of red, green and blue. Throws Error where the file cannot be written.
void write_png16(const std::string& path, const DeepImage& image);
void write_png16(const std::string& path, const DeepColorImage& image);

/// OpenEXR with 32-bit floats: one channel, or x, y, z as red, green, blue. Throws Error where the file cannot be
/// written, or OpenCV was built without OpenEXR.
void write_exr(const std::string& path, const Image<float>& image);
void write_exr(const std::string& path, const Image<Eigen::Vector3f>& image);

}  // namespace cpplus
