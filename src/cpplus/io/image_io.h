#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/core/image.h"

namespace cpplus {

/// Reads an image file (JPEG, PNG and what else OpenCV reads) as it was recorded: an EXIF orientation is ignored,
/// because camera models and poses refer to the pixels of the sensor. Deeper images become 8 bits a channel, alpha is
/// dropped. Throws Error naming the file when it is missing, not an image, or broken off or damaged inside (decoders
/// tend to fill the rest with grey and say nothing).
ColorImage read_color_image(const std::string& path);

/// The same as luma (BT.601); for JPEG without a detour through colour.
GrayImage read_gray_image(const std::string& path);

/// Luma as OpenCV computes it: 0.299 R + 0.587 G + 0.114 B, rounded.
GrayImage to_gray(const ColorImage& image);

void write_png(const std::string& path, const ColorImage& image);

/// The image as the bytes of a JPEG file. quality in [1, 100].
std::vector<uint8_t> encode_jpeg(const ColorImage& image, int quality);
void write_jpeg(const std::string& path, const ColorImage& image, int quality);

/// Width and height from the header, without decoding the pixels where the format allows that.
struct ImageSize {
  int width = 0;
  int height = 0;
};
ImageSize read_image_size(const std::string& path);

}  // namespace cpplus
