#include "cpplus/io/image_io.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/jpeg.h"

namespace cpplus {
namespace {

std::vector<uint8_t> read_bytes(const std::string& path) {
  BlockReader reader(path);
  constexpr uint64_t kMaxSize = uint64_t{1} << 30;
  if (reader.file_size() > kMaxSize) {
    throw Error(fmt::format("{}: {} bytes are too many for an image", path, reader.file_size()));
  }
  const uint8_t* data = reader.take(reader.file_size());
  return {data, data + reader.file_size()};
}

uint32_t big_endian_number(const uint8_t* data) {
  return static_cast<uint32_t>(data[0]) << 24 | static_cast<uint32_t>(data[1]) << 16 |
         static_cast<uint32_t>(data[2]) << 8 | data[3];
}

/// A PNG is checked before libpng sees it, which writes to stderr: chunks (length, type, data, checksum) up to IEND.
void check_png(const std::string& path, const std::vector<uint8_t>& bytes) {
  constexpr uint8_t kSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (bytes.size() < sizeof(kSignature) || !std::equal(std::begin(kSignature), std::end(kSignature), bytes.begin())) {
    return;
  }
  size_t offset = sizeof(kSignature);
  constexpr size_t kFrame = 12;
  while (true) {
    const size_t left = bytes.size() - offset;
    const size_t length = left >= kFrame ? big_endian_number(&bytes[offset]) : 0;
    if (left < kFrame || left - kFrame < length) {
      throw Error(fmt::format("{}: corrupt PNG: broken off at {} bytes", path, bytes.size()));
    }
    const uint8_t* type = &bytes[offset + 4];
    if (crc32(0, type, static_cast<uInt>(length + 4)) != big_endian_number(type + 4 + length)) {
      throw Error(fmt::format("{}: corrupt PNG: wrong checksum at offset {}", path, offset));
    }
    if (std::equal(type, type + 4, "IEND")) return;
    offset += length + kFrame;
  }
}

cv::Mat decode_with_opencv(const std::string& path, const std::vector<uint8_t>& bytes, int flags) {
  check_png(path, bytes);
  cv::Mat decoded;
  try {
    if (!bytes.empty()) decoded = cv::imdecode(bytes, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& exception) {
    throw Error(fmt::format("{}: cannot decode the image: {}", path, exception.err));
  }
  if (decoded.empty()) throw Error(fmt::format("{}: not an image, or a corrupt one ({} bytes)", path, bytes.size()));
  return decoded;
}

}  // namespace

ColorImage read_color_image(const std::string& path) {
  const std::vector<uint8_t> bytes = read_bytes(path);
  if (is_jpeg(bytes)) return decode_jpeg_color(path, bytes);
  const cv::Mat decoded = decode_with_opencv(path, bytes, cv::IMREAD_COLOR);
  ColorImage image(decoded.cols, decoded.rows);
  cv::Mat target(decoded.rows, decoded.cols, CV_8UC3, image.pixels.data());
  cv::cvtColor(decoded, target, cv::COLOR_BGR2RGB);
  return image;
}

GrayImage read_gray_image(const std::string& path) {
  const std::vector<uint8_t> bytes = read_bytes(path);
  if (is_jpeg(bytes)) return decode_jpeg_gray(path, bytes);
  const cv::Mat decoded = decode_with_opencv(path, bytes, cv::IMREAD_GRAYSCALE);
  GrayImage image(decoded.cols, decoded.rows);
  cv::Mat target(decoded.rows, decoded.cols, CV_8UC1, image.pixels.data());
  decoded.copyTo(target);
  return image;
}

GrayImage to_gray(const ColorImage& image) {
  GrayImage gray(image.width, image.height);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const Rgb& rgb = image.pixels[i];
    // The weights in 1 / 2^14, rounded.
    gray.pixels[i] = static_cast<uint8_t>((rgb[0] * 4899 + rgb[1] * 9617 + rgb[2] * 1868 + 8192) >> 14);
  }
  return gray;
}

void write_png(const std::string& path, const ColorImage& image) {
  if (image.empty()) throw Error(fmt::format("{}: cannot write: the image is empty", path));
  const cv::Mat rgb(image.height, image.width, CV_8UC3, const_cast<Rgb*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  if (!cv::imencode(".png", bgr, bytes)) throw Error(fmt::format("{}: cannot encode the image as PNG", path));
  AtomicFile file(path);
  file.stream().write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

ImageSize read_image_size(const std::string& path) {
  const std::vector<uint8_t> bytes = read_bytes(path);
  if (is_jpeg(bytes)) return decode_jpeg_size(path, bytes);
  const cv::Mat decoded = decode_with_opencv(path, bytes, cv::IMREAD_GRAYSCALE);
  return {decoded.cols, decoded.rows};
}

}  // namespace cpplus
