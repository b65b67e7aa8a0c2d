#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

namespace cpplus {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are");

/// Appends numbers to bytes. A function template that takes either this or a ByteUnpacker, and calls the same members
/// for the same fields, both writes and reads them.
class BytePacker {
 public:
  explicit BytePacker(std::string* bytes) : bytes_(*bytes) {}

  template <typename T>
  void number(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  /// What has data() and size(), of numbers.
  template <typename Matrix>
  void matrix(const Matrix& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()),
                  static_cast<size_t>(values.size()) * sizeof(*values.data()));
  }
  template <typename Array>
  void size(const Array& values) {
    number(static_cast<uint64_t>(values.size()));
  }

 private:
  std::string& bytes_;
};

/// Takes numbers from bytes. Where these end too early what is read stays as it was, and is_at_end() is false for good.
class ByteUnpacker {
 public:
  explicit ByteUnpacker(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  template <typename T>
  void number(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    take(&value, sizeof(T));
  }
  template <typename Matrix>
  void matrix(Matrix& values) {
    take(values.data(), static_cast<size_t>(values.size()) * sizeof(*values.data()));
  }
  template <typename Array>
  void size(Array& values) {
    uint64_t count = 0;
    number(count);
    is_well_ = is_well_ && count <= bytes_.size();  // an element has a byte at least
    values.resize(is_well_ ? count : 0);
  }
  bool is_at_end() const { return is_well_ && bytes_.empty(); }

 private:
  void take(void* to, size_t size) {
    is_well_ = is_well_ && size <= bytes_.size();
    if (!is_well_ || size == 0) return;
    std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }

  std::span<const uint8_t> bytes_;
  bool is_well_ = true;
};

}  // namespace cpplus
