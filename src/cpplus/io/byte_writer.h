#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <type_traits>

namespace cpplus {

/// Gathers little-endian numbers and hands them to a stream in blocks.
class ByteWriter {
 public:
  explicit ByteWriter(std::ostream* stream) : stream_(stream) {}
  ~ByteWriter() { flush(); }
  ByteWriter(const ByteWriter&) = delete;
  ByteWriter& operator=(const ByteWriter&) = delete;

  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    put_bytes(reinterpret_cast<const char*>(&value), sizeof(T));
  }

  void put_bytes(const char* data, size_t size) {
    block_.append(data, size);
    if (block_.size() >= kBlockSize) flush();
  }

  void flush() {
    stream_->write(block_.data(), static_cast<std::streamsize>(block_.size()));
    block_.clear();
  }

 private:
  static constexpr size_t kBlockSize = size_t{1} << 18;

  std::ostream* stream_;
  std::string block_;
};

}  // namespace cpplus
