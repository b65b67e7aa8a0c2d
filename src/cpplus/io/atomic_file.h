#pragma once

#include <fstream>
#include <string>

namespace cpplus {

/// A file that appears whole or not at all: what is written to stream() goes to a temporary file beside the target,
/// and commit() renames it onto the target. Without commit() the temporary is removed and the target is untouched.
class AtomicFile {
 public:
  /// Opens the temporary; missing parent folders are made. Throws Error naming the path and the reason.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return stream_; }
  const std::string& path() const { return path_; }

  /// Flushes, closes and renames. Throws Error when anything could not be written (disk full, folder gone).
  void commit();

 private:
  std::string path_;
  std::string temporary_;
  std::ofstream stream_;
  bool committed_ = false;
};

/// Writes one whole text file atomically.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace cpplus
