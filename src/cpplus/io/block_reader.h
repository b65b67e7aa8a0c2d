#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace cpplus {

/// Reads a file from front to back through one buffer of at most 1 MiB (more for longer records), so that a reader's
/// memory does not grow with the file. What it hands out is valid until the next call. Errors name the file.
class BlockReader {
 public:
  explicit BlockReader(const std::string& path);

  const std::string& path() const { return path_; }
  uint64_t file_size() const { return file_size_; }
  /// Offset in the file of the next byte.
  uint64_t position() const { return position_; }
  uint64_t remaining() const { return file_size_ - position_; }

  /// The next `size` bytes, contiguous. Throws Error "truncated" when the file ends before.
  const uint8_t* take(size_t size);
  void skip(uint64_t size);

  /// The next line without its "\n" or "\r\n"; false at the end of the file. Throws Error for a line over 16 MiB.
  bool take_line(std::string_view* line);
  /// Number of the line that take_line gave last, from 1.
  size_t line_number() const { return line_number_; }

 private:
  bool refill(size_t wanted);

  std::string path_;
  std::ifstream stream_;
  uint64_t file_size_ = 0;
  uint64_t position_ = 0;
  size_t line_number_ = 0;
  std::vector<uint8_t> buffer_;
  size_t begin_ = 0;
  size_t end_ = 0;
};

}  // namespace cpplus
