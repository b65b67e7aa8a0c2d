#include "cpplus/io/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "cpplus/core/error.h"

namespace cpplus {

MappedFile::MappedFile(const std::string& path) {
  const auto fail = [&] { throw Error(fmt::format("{}: cannot read: {}", path, std::strerror(errno))); };
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail();
  struct stat status {};
  fstat(file, &status);
  if (S_ISDIR(status.st_mode)) {
    close(file);
    throw Error(fmt::format("{}: is a folder, not a file", path));
  }
  const auto size = static_cast<size_t>(status.st_size);
  void* data = size > 0 ? mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0) : nullptr;
  const int mapping_error = errno;
  close(file);  // the mapping stays
  errno = mapping_error;
  if (data == MAP_FAILED) fail();
  bytes_ = {static_cast<const uint8_t*>(data), size};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<uint8_t*>(bytes_.data()), bytes_.size());
}

}  // namespace cpplus
