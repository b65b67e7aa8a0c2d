#include "cpplus/io/lz4.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

const std::string kHeader("\x04\x22\x4d\x18\x60\x70\x00", 7);  // version 1, blocks of 4 MB, no sizes and checksums

std::string block(const std::string& bytes, bool is_compressed = true) {
  return bytes_of(static_cast<uint32_t>(bytes.size()) | (is_compressed ? 0u : 0x80000000u)) + bytes;
}

std::string decoded(const std::string& frame, size_t max_size = 1000) {
  const std::vector<uint8_t> bytes =
      decode_lz4_frame("f", reinterpret_cast<const uint8_t*>(frame.data()), frame.size(), max_size);
  return {bytes.begin(), bytes.end()};
}

const std::string kEnd(4, '\0');

TEST(Lz4, LiteralsMatchesAndPlainBlocks) {
  // Three literals, then a match of 4 + 2 bytes three back, which overlaps itself; then a literal.
  const std::string block_bytes = std::string(
                                      "\x32"
                                      "abc",
                                      4) +
                                  std::string("\x03\x00", 2) + std::string("\x10z", 2);
  EXPECT_EQ(decoded(kHeader + block(block_bytes) + kEnd), "abcabcabcz");
  // The second block's match reaches into the first block.
  const std::string plain = block("hello", false);
  EXPECT_EQ(decoded(kHeader + plain + block(std::string("\x00\x05\x00\x10!", 5)) + kEnd), "hellohell!");
  EXPECT_EQ(decoded(kHeader + kEnd), "");
}

TEST(Lz4, LongLengthsContinue) {
  // 15 + 255 + 30 literals, then a match of 4 + 15 + 1.
  const std::string literals(300, 'x');
  const std::string bytes =
      std::string("\xff\xff\x1e", 3) + literals + std::string("\x01\x00\x01", 3) + std::string("\x10y", 2);
  EXPECT_EQ(decoded(kHeader + block(bytes) + kEnd), std::string(320, 'x') + "y");
}

TEST(Lz4, SizesAndChecksumsAreSkipped) {
  const std::string header = std::string("\x04\x22\x4d\x18\x7c\x70", 6) + bytes_of(uint64_t{1}) + std::string(1, '\0');
  EXPECT_EQ(decoded(header + block("a", false) + std::string(4, '?') + kEnd + std::string(4, '?')), "a");
}

TEST(Lz4, BadFramesAreNamed) {
  const std::string good = kHeader + block("hello", false) + kEnd;
  EXPECT_ERROR(decoded("plain text"), "f: its LZ4 data do not begin as a frame does");
  for (size_t size = 4; size < good.size(); ++size)
    EXPECT_ERROR(decoded(good.substr(0, size)), "f: its LZ4 data are broken off");
  EXPECT_ERROR(decoded(good, 4), "f: its LZ4 data decode to more than 4 bytes");
  EXPECT_ERROR(decoded(kHeader +
                       block(std::string("\x10"
                                         "a\x02\x00\x00",
                                         5)) +
                       kEnd),
               "f: its LZ4 data are corrupt");
  EXPECT_ERROR(decoded(std::string("\x04\x22\x4d\x18\x61\x70\x00", 7) + kEnd),
               "f: LZ4 frames of this kind are not known");
}

}  // namespace
}  // namespace cpplus
