#include "cpplus/io/atomic_file.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "cpplus/core/error.h"

namespace cpplus {
namespace fs = std::filesystem;

namespace {

constexpr const char* kEnding = ".partial";

/// Whether a file name is that of a temporary of `target` ("" = of anything) whose process is no more.
bool is_leftover(const std::string& name, const std::string& target) {
  if (!name.starts_with(".") || !name.ends_with(kEnding)) return false;
  const std::string stem = name.substr(1, name.size() - 1 - std::strlen(kEnding));
  const size_t dot = stem.rfind('.');
  if (dot == std::string::npos || (!target.empty() && stem.substr(0, dot) != target)) return false;
  const std::string number = stem.substr(dot + 1);
  pid_t process = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), process);
  const bool is_number = error == std::errc() && end == number.data() + number.size() && process > 0;
  return is_number && kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

std::string temporary_path(const std::string& path) {
  const fs::path target(path);
  return (target.parent_path() / fmt::format(".{}.{}{}", target.filename().string(), getpid(), kEnding)).string();
}

void remove_leftovers(const std::string& path) {
  fs::path target = fs::absolute(path).lexically_normal();
  if (!target.has_filename()) target = target.parent_path();
  std::vector<fs::path> leftovers;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(target.parent_path(), ignored)) {
    if (is_leftover(entry.path().filename().string(), target.filename().string())) leftovers.push_back(entry.path());
  }
  for (const auto& entry : fs::recursive_directory_iterator(target, ignored)) {
    if (is_leftover(entry.path().filename().string(), "")) leftovers.push_back(entry.path());
  }
  for (const fs::path& leftover : leftovers) fs::remove_all(leftover, ignored);
}

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  const fs::path target(path);
  if (!target.has_filename()) throw Error(fmt::format("{}: cannot write: no file name", path));
  if (fs::is_directory(target)) throw Error(fmt::format("{}: cannot write: is a folder", path));
  std::error_code failure;
  if (target.has_parent_path()) fs::create_directories(target.parent_path(), failure);
  if (failure) throw Error(fmt::format("{}: cannot make its folder: {}", path, failure.message()));
  temporary_ = temporary_path(path);
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
