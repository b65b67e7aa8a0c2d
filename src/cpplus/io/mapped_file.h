#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace cpplus {

/// A file mapped into memory, read-only. Whoever replaces the file by renaming does not disturb it.
class MappedFile {
 public:
  /// Throws Error naming the file where it cannot be read.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const uint8_t> bytes() const { return bytes_; }

 private:
  std::span<const uint8_t> bytes_;
};

}  // namespace cpplus
