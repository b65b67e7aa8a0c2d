#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/io/image_io.h"

namespace cpplus {

/// True when the bytes begin as a JPEG file does.
bool is_jpeg(const std::vector<uint8_t>& bytes);

/// Decode with libjpeg. What libjpeg only warns about although pixels are lost (file broken off, damaged entropy data)
/// is an Error here; `path` is for its message.
ColorImage decode_jpeg_color(const std::string& path, const std::vector<uint8_t>& bytes);
GrayImage decode_jpeg_gray(const std::string& path, const std::vector<uint8_t>& bytes);
ImageSize decode_jpeg_size(const std::string& path, const std::vector<uint8_t>& bytes);

}  // namespace cpplus
