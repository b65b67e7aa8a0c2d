#include "cpplus/io/jpeg.h"

#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>
// jpeglib.h needs cstdio before it.
#include <jerror.h>
#include <jpeglib.h>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

/// libjpeg's error handler with a way back: its C frames must not be crossed by an exception.
struct ErrorHandler {
  jpeg_error_mgr base;
  std::jmp_buf on_error;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void leave(j_common_ptr decoder) {
  ErrorHandler* handler = reinterpret_cast<ErrorHandler*>(decoder->err);
  handler->base.format_message(decoder, handler->message);
  std::longjmp(handler->on_error, 1);
}

void on_message(j_common_ptr decoder, int level) {
  if (level >= 0) return;
  switch (decoder->err->msg_code) {
    case JWRN_EXTRANEOUS_DATA:  // bytes between markers: nothing is lost
    case JWRN_ADOBE_XFORM:
    case JWRN_JFIF_MAJOR:
      return;
    default:
      leave(decoder);
  }
}

/// Called between header and pixels with the image's size: returns where row 0 goes, or null to stop there.
/// Plain data only: a longjmp may leave the frame below.
struct Target {
  J_COLOR_SPACE color_space;
  int num_channels;
  void* image;
  uint8_t* (*allocate)(void* image, int width, int height);
};

/// Returns false with handler->message set. Holds no object with a destructor, because of setjmp.
bool decode(const std::vector<uint8_t>* bytes, const Target* target, ErrorHandler* handler, ImageSize* size) {
  jpeg_decompress_struct decoder;
  decoder.err = jpeg_std_error(&handler->base);
  handler->base.error_exit = leave;
  handler->base.emit_message = on_message;
  if (setjmp(handler->on_error) != 0) {
    jpeg_destroy_decompress(&decoder);
    return false;
  }
  jpeg_create_decompress(&decoder);
  jpeg_mem_src(&decoder, bytes->data(), bytes->size());
  jpeg_read_header(&decoder, TRUE);
  size->width = static_cast<int>(decoder.image_width);
  size->height = static_cast<int>(decoder.image_height);
  if (target != nullptr) {
    decoder.out_color_space = target->color_space;
    jpeg_start_decompress(&decoder);
    uint8_t* pixels = target->allocate(target->image, size->width, size->height);
    const size_t stride = static_cast<size_t>(size->width) * static_cast<size_t>(target->num_channels);
    while (decoder.output_scanline < decoder.output_height) {
      JSAMPROW row = pixels + stride * decoder.output_scanline;
      jpeg_read_scanlines(&decoder, &row, 1);
    }
    jpeg_finish_decompress(&decoder);
  }
  jpeg_destroy_decompress(&decoder);
  return true;
}

ImageSize decode_or_throw(const std::string& path, const std::vector<uint8_t>& bytes, const Target* target) {
  ErrorHandler handler;
  ImageSize size;
  if (!decode(&bytes, target, &handler, &size)) throw Error(fmt::format("{}: corrupt JPEG: {}", path, handler.message));
  return size;
}

template <typename Pixel>
uint8_t* allocate(void* image, int width, int height) {
  Image<Pixel>* typed = static_cast<Image<Pixel>*>(image);
  *typed = Image<Pixel>(width, height);
  return reinterpret_cast<uint8_t*>(typed->pixels.data());
}

}  // namespace

bool is_jpeg(const std::vector<uint8_t>& bytes) {
  return bytes.size() > 2 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

ColorImage decode_jpeg_color(const std::string& path, const std::vector<uint8_t>& bytes) {
  ColorImage image;
  const Target target{JCS_RGB, 3, &image, allocate<Rgb>};
  decode_or_throw(path, bytes, &target);
  return image;
}

GrayImage decode_jpeg_gray(const std::string& path, const std::vector<uint8_t>& bytes) {
  GrayImage image;
  const Target target{JCS_GRAYSCALE, 1, &image, allocate<uint8_t>};
  decode_or_throw(path, bytes, &target);
  return image;
}

ImageSize decode_jpeg_size(const std::string& path, const std::vector<uint8_t>& bytes) {
  return decode_or_throw(path, bytes, nullptr);
}

}  // namespace cpplus
