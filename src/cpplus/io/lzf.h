#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/io/block_reader.h"

namespace cpplus {

/// Decodes an LZF stream (Marc Lehmann's liblzf, as PCD's binary_compressed uses it) piece by piece. The format refers
/// back at most 8 KiB, so neither the compressed nor the decoded data has to be in memory as a whole.
///
/// Format: a control byte c < 32 is followed by c + 1 literal bytes; otherwise it refers back by
/// ((c & 31) << 8 | last byte) + 1 bytes, for (c >> 5) + 2 bytes, where 7 in the top bits adds one more length byte.
class LzfDecoder {
 public:
  /// Reads `compressed_size` bytes from the reader's present position.
  LzfDecoder(BlockReader* reader, uint64_t compressed_size);

  /// Decodes the next `size` bytes. Throws Error naming the file when the stream ends before or refers before its
  /// start.
  void decode(uint8_t* data, size_t size);

 private:
  uint8_t next_byte();
  void start_run();

  BlockReader* reader_;
  uint64_t compressed_left_;
  uint64_t decoded_ = 0;
  std::vector<uint8_t> window_;
  size_t literals_left_ = 0;
  size_t copies_left_ = 0;
  size_t distance_ = 0;
};

}  // namespace cpplus
