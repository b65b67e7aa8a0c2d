#include "cpplus/io/scratch_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"

namespace cpplus {
namespace {

/// One call moves at most 2 GiB.
constexpr size_t kMaxStep = size_t{1} << 30;

int open_temporary(const std::string& target, const std::string& path, int flags) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | flags, S_IRUSR | S_IWUSR);
  if (file < 0) throw Error(fmt::format("{}: cannot make a temporary file beside it: {}", target, strerror(errno)));
  return file;
}

}  // namespace

ScratchFile::ScratchFile(const std::string& target) : target_(target) {
  const std::filesystem::path folder = std::filesystem::path(target).parent_path();
  std::error_code failure;
  if (!folder.empty()) std::filesystem::create_directories(folder, failure);
  // The name is there for a moment only.
  const std::string name = temporary_path(target + ".scratch");
  file_ = open_temporary(target, name, O_TRUNC);
  unlink(name.c_str());
}

ScratchFile::ScratchFile(const std::string& target, const std::string& path)
    : target_(target), file_(open_temporary(target, path, 0)) {}

ScratchFile::~ScratchFile() { close(file_); }

void ScratchFile::write(uint64_t offset, const void* data, size_t size) {
  const char* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t done = pwrite(file_, bytes, std::min(size, kMaxStep), static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) throw Error(fmt::format("{}: cannot write temporary data: {}", target_, strerror(errno)));
    bytes += done;
    offset += static_cast<uint64_t>(done);
    size -= static_cast<size_t>(done);
  }
}

void ScratchFile::read(uint64_t offset, void* data, size_t size) const {
  char* bytes = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t done = pread(file_, bytes, std::min(size, kMaxStep), static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) throw Error(fmt::format("{}: cannot read temporary data: {}", target_, strerror(errno)));
    bytes += done;
    offset += static_cast<uint64_t>(done);
    size -= static_cast<size_t>(done);
  }
}

}  // namespace cpplus
