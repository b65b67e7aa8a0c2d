#include "cpplus/io/lzf.h"

#include <fmt/format.h>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

constexpr size_t kWindowSize = size_t{1} << 13;

}  // namespace

LzfDecoder::LzfDecoder(BlockReader* reader, uint64_t compressed_size)
    : reader_(reader), compressed_left_(compressed_size), window_(kWindowSize) {}

uint8_t LzfDecoder::next_byte() {
  if (compressed_left_ == 0) {
    throw Error(fmt::format("{}: the compressed data ends after {} decoded bytes", reader_->path(), decoded_));
  }
  --compressed_left_;
  return *reader_->take(1);
}

void LzfDecoder::start_run() {
  const size_t control = next_byte();
  if (control < 32) {
    literals_left_ = control + 1;
    return;
  }
  size_t length = control >> 5;
  if (length == 7) length += next_byte();
  copies_left_ = length + 2;
  distance_ = ((control & 31) << 8 | next_byte()) + 1;
  if (distance_ > decoded_) {
    throw Error(fmt::format("{}: corrupt compressed data at offset {}", reader_->path(), reader_->position()));
  }
}

void LzfDecoder::decode(uint8_t* data, size_t size) {
  for (size_t i = 0; i < size; ++i) {
    if (literals_left_ == 0 && copies_left_ == 0) start_run();
    uint8_t byte = 0;
    if (literals_left_ > 0) {
      byte = next_byte();
      --literals_left_;
    } else {
      byte = window_[(decoded_ - distance_) % kWindowSize];
      --copies_left_;
    }
    window_[decoded_ % kWindowSize] = byte;
    ++decoded_;
    data[i] = byte;
  }
}

}  // namespace cpplus
