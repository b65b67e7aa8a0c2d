#include "cpplus/io/block_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

constexpr size_t kBlockSize = size_t{1} << 20;
constexpr size_t kMaxLineSize = size_t{1} << 24;

}  // namespace

BlockReader::BlockReader(const std::string& path) : path_(path) {
  if (std::filesystem::is_directory(path)) throw Error(fmt::format("{}: is a folder, not a file", path));
  stream_.open(path, std::ios::binary);
  if (!stream_) throw Error(fmt::format("{}: cannot read: {}", path, std::strerror(errno)));
  std::error_code failure;
  file_size_ = std::filesystem::file_size(path, failure);
  if (failure) throw Error(fmt::format("{}: cannot read: {}", path, failure.message()));
  buffer_.resize(static_cast<size_t>(std::min<uint64_t>(kBlockSize, file_size_ + 1)));
}

bool BlockReader::refill(size_t wanted) {
  if (end_ - begin_ >= wanted) return true;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  if (wanted > buffer_.size()) buffer_.resize(std::max(wanted, 2 * buffer_.size()));
  stream_.read(reinterpret_cast<char*>(buffer_.data() + end_), static_cast<std::streamsize>(buffer_.size() - end_));
  end_ += static_cast<size_t>(stream_.gcount());
  return end_ >= wanted;
}

const uint8_t* BlockReader::take(size_t size) {
  if (size > remaining() || !refill(size)) {
    throw Error(fmt::format("{}: truncated: {} bytes wanted at offset {}, the file has {} bytes", path_, size,
                            position_, file_size_));
  }
  const uint8_t* data = buffer_.data() + begin_;
  begin_ += size;
  position_ += size;
  return data;
}

void BlockReader::skip(uint64_t size) {
  while (size > 0) {
    const size_t step = static_cast<size_t>(std::min<uint64_t>(size, kBlockSize));
    take(step);
    size -= step;
  }
}

bool BlockReader::take_line(std::string_view* line) {
  if (!refill(1)) return false;
  size_t searched = 0;
  const uint8_t* newline = nullptr;
  while (newline == nullptr) {
    const size_t available = end_ - begin_;
    newline = static_cast<const uint8_t*>(std::memchr(buffer_.data() + begin_ + searched, '\n', available - searched));
    if (newline != nullptr) break;
    searched = available;
    if (available > kMaxLineSize) {
      throw Error(fmt::format("{}: line {} is longer than {} bytes", path_, line_number_ + 1, kMaxLineSize));
    }
    if (!refill(available + 1)) break;
  }
  const uint8_t* data = buffer_.data() + begin_;
  size_t size = newline != nullptr ? static_cast<size_t>(newline - data) : end_ - begin_;
  const size_t consumed = size + (newline != nullptr ? 1 : 0);
  begin_ += consumed;
  position_ += consumed;
  ++line_number_;
  if (size > 0 && data[size - 1] == '\r') --size;
  *line = std::string_view(reinterpret_cast<const char*>(data), size);
  return true;
}

}  // namespace cpplus
