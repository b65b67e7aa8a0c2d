#include "cpplus/io/lz4.h"

#include <fmt/format.h>

#include <cstring>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

/// Bytes that are taken from front to back.
class Input {
 public:
  Input(const std::string& where, const uint8_t* data, size_t size) : where_(where), data_(data), size_(size) {}

  const uint8_t* take(size_t count) {
    if (count > size_ - at_) throw Error(fmt::format("{}: its LZ4 data are broken off", where_));
    at_ += count;
    return data_ + at_ - count;
  }
  uint8_t byte() { return *take(1); }
  template <typename T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof(T)), sizeof(T));
    return value;
  }
  bool at_end() const { return at_ == size_; }

  /// A length whose first four bits came with a token: 15 is continued by bytes, the last of which is not 255.
  size_t length(uint8_t nibble) {
    size_t length = nibble;
    if (nibble == 15) {
      uint8_t more = 0;
      do {
        more = byte();
        length += more;
      } while (more == 255);
    }
    return length;
  }

 private:
  const std::string& where_;
  const uint8_t* data_;
  size_t size_;
  size_t at_ = 0;
};

void check_room(const std::string& where, size_t size, size_t more, size_t max_size) {
  if (more > max_size - size)
    throw Error(fmt::format("{}: its LZ4 data decode to more than {} bytes", where, max_size));
}

/// Sequences of literals and a match each, whose offset may reach into earlier blocks; the last has literals only.
void decode_block(const std::string& where, Input block, size_t max_size, std::vector<uint8_t>* out) {
  constexpr size_t kLeastMatch = 4;
  while (!block.at_end()) {
    const uint8_t token = block.byte();
    const size_t num_literals = block.length(token >> 4);
    check_room(where, out->size(), num_literals, max_size);
    const uint8_t* literals = block.take(num_literals);
    out->insert(out->end(), literals, literals + num_literals);
    if (block.at_end()) return;
    const size_t offset = block.number<uint16_t>();
    const size_t length = block.length(token & 15) + kLeastMatch;
    check_room(where, out->size(), length, max_size);
    if (offset == 0 || offset > out->size()) throw Error(fmt::format("{}: its LZ4 data are corrupt", where));
    // Byte by byte, since a match may overlap what it makes.
    for (size_t i = 0; i < length; ++i) out->push_back((*out)[out->size() - offset]);
  }
}

}  // namespace

std::vector<uint8_t> decode_lz4_frame(const std::string& where, const uint8_t* data, size_t size, size_t max_size) {
  constexpr uint32_t kMagic = 0x184D2204;
  constexpr uint32_t kNotCompressed = 0x80000000;
  Input input(where, data, size);
  if (input.number<uint32_t>() != kMagic)
    throw Error(fmt::format("{}: its LZ4 data do not begin as a frame does", where));
  const uint8_t flags = input.byte();
  const bool has_block_checksums = (flags & 0x10) != 0;
  const bool has_content_size = (flags & 0x08) != 0;
  const bool has_dictionary = (flags & 0x01) != 0;
  if (flags >> 6 != 1 || has_dictionary) throw Error(fmt::format("{}: LZ4 frames of this kind are not known", where));
  input.byte();  // the largest size of a block
  if (has_content_size) input.number<uint64_t>();
  input.byte();  // checksum of this header
  std::vector<uint8_t> out;
  while (const uint32_t head = input.number<uint32_t>()) {
    const size_t block_size = head & ~kNotCompressed;
    const uint8_t* block = input.take(block_size);
    if (head & kNotCompressed) {
      check_room(where, out.size(), block_size, max_size);
      out.insert(out.end(), block, block + block_size);
    } else {
      decode_block(where, Input(where, block, block_size), max_size, &out);
    }
    if (has_block_checksums) input.number<uint32_t>();
  }
  return out;
}

}  // namespace cpplus
