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
  const std::string& temporary() const { return temporary_; }

  /// Flushes, closes and renames. Throws Error when anything could not be written (disk full, folder gone).
  void commit();

 private:
  std::string path_;
  std::string temporary_;
  std::ofstream stream_;
  bool committed_ = false;
};

/// Where what will be at `path` is written first: beside it, named after it and this process.
std::string temporary_path(const std::string& path);

/// Removes what processes that were killed have left of files and folders below and beside `path`: temporaries, whose
/// names hold the number of a process that is no more. Those beside it only where they are of `path` itself.
void remove_leftovers(const std::string& path);

/// Writes one whole text file atomically.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace cpplus
