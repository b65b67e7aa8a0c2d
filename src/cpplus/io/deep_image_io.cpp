#include "cpplus/io/deep_image_io.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"

namespace cpplus {
namespace {

/// Encodes channels in OpenCV's order (blue, green, red) and writes them.
void write_encoded(const std::string& path, const char* extension, const cv::Mat& image) {
  if (image.empty()) throw Error(fmt::format("{}: cannot write: the image is empty", path));
  std::vector<uint8_t> bytes;
  std::string reason;
  try {
    if (!cv::imencode(extension, image, bytes)) bytes.clear();
  } catch (const cv::Exception& exception) {
    reason = ": " + exception.err;
    bytes.clear();
  }
  if (bytes.empty()) throw Error(fmt::format("{}: this OpenCV cannot write {}{}", path, extension, reason));
  AtomicFile file(path);
  file.stream().write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

template <typename Pixel>
cv::Mat mat_of(const Image<Pixel>& image, int type) {
  return cv::Mat(image.height, image.width, type, const_cast<Pixel*>(image.pixels.data()));
}

/// The image with its first and its last channel swapped.
template <typename Pixel>
Image<Pixel> reversed_channels(Image<Pixel> image) {
  for (Pixel& pixel : image.pixels) std::swap(pixel[0], pixel[2]);
  return image;
}

}  // namespace

void write_png16(const std::string& path, const DeepImage& image) {
  write_encoded(path, ".png", mat_of(image, CV_16UC1));
}

void write_png16(const std::string& path, const DeepColorImage& image) {
  const DeepColorImage bgr = reversed_channels(image);
  write_encoded(path, ".png", mat_of(bgr, CV_16UC3));
}

void write_exr(const std::string& path, const Image<float>& image) {
  write_encoded(path, ".exr", mat_of(image, CV_32FC1));
}

void write_exr(const std::string& path, const Image<Eigen::Vector3f>& image) {
  const Image<Eigen::Vector3f> zyx = reversed_channels(image);
  write_encoded(path, ".exr", mat_of(zyx, CV_32FC3));
}

}  // namespace cpplus
