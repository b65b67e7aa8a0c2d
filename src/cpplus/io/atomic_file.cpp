#include "cpplus/io/atomic_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "cpplus/core/error.h"

namespace cpplus {
namespace fs = std::filesystem;

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  const fs::path target(path);
  if (!target.has_filename()) throw Error(fmt::format("{}: cannot write: no file name", path));
  if (fs::is_directory(target)) throw Error(fmt::format("{}: cannot write: is a folder", path));
  std::error_code failure;
  if (target.has_parent_path()) fs::create_directories(target.parent_path(), failure);
  if (failure) throw Error(fmt::format("{}: cannot make its folder: {}", path, failure.message()));
  temporary_ = (target.parent_path() / fmt::format(".{}.{}.partial", target.filename().string(), getpid())).string();
  stream_.open(temporary_, std::ios::binary | std::ios::trunc);
  if (!stream_) throw Error(fmt::format("{}: cannot write: {}", path, std::strerror(errno)));
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  stream_.close();
  if (!stream_) throw Error(fmt::format("{}: cannot write all of it: {}", path_, std::strerror(errno)));
  std::error_code failure;
  fs::rename(temporary_, path_, failure);
  if (failure) throw Error(fmt::format("{}: cannot write: {}", path_, failure.message()));
  committed_ = true;
}

void write_text_file(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.stream().write(text.data(), static_cast<std::streamsize>(text.size()));
  file.commit();
}

}  // namespace cpplus
