#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace cpplus {

/// A temporary file. Errors name the file that it is for.
class ScratchFile {
 public:
  /// One without a name, in the folder of the file that it is for: it is gone with the process, however that ends.
  explicit ScratchFile(const std::string& target);
  /// One at `path`, which stays. What is there already is kept.
  ScratchFile(const std::string& target, const std::string& path);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void write(uint64_t offset, const void* data, size_t size);
  /// The bytes must have been written.
  void read(uint64_t offset, void* data, size_t size) const;

 private:
  std::string target_;
  int file_ = -1;
};

}  // namespace cpplus
