#include "cpplus/io/npz_io.h"

#include <zlib.h>

#include <cmath>

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

std::string npy(const std::string& type, const std::string& shape, const std::string& data,
                const std::string& order = "False") {
  std::string header = "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': (" + shape + "), }";
  header.resize(118, ' ');
  return "\x93NUMPY" + std::string("\x01\x00", 2) + bytes_of<uint16_t>(118) + header + data;
}

std::string deflate_raw(const std::string& bytes) {
  std::string compressed(bytes.size() + 100, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(compressed.data());
  stream.avail_out = static_cast<uInt>(compressed.size());
  deflate(&stream, Z_FINISH);
  compressed.resize(stream.total_out);
  deflateEnd(&stream);
  return compressed;
}

/// A zip archive of one entry.
std::string zip(const std::string& name, const std::string& bytes, bool compress) {
  const std::string data = compress ? deflate_raw(bytes) : bytes;
  const auto crc =
      static_cast<uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
  const std::string common = bytes_of<uint16_t>(20) + bytes_of<uint16_t>(0) + bytes_of<uint16_t>(compress ? 8 : 0) +
                             bytes_of<uint32_t>(0) + bytes_of(crc) + bytes_of(static_cast<uint32_t>(data.size())) +
                             bytes_of(static_cast<uint32_t>(bytes.size())) +
                             bytes_of(static_cast<uint16_t>(name.size())) + bytes_of<uint16_t>(0);
  const std::string local = "PK\x03\x04" + common + name + data;
  const std::string directory =
      "PK\x01\x02" + bytes_of<uint16_t>(20) + common + std::string(10, '\0') + bytes_of<uint32_t>(0) + name;
  return local + directory + "PK\x05\x06" + std::string(4, '\0') + bytes_of<uint16_t>(1) + bytes_of<uint16_t>(1) +
         bytes_of(static_cast<uint32_t>(directory.size())) + bytes_of(static_cast<uint32_t>(local.size())) +
         bytes_of<uint16_t>(0);
}

class NpzIo : public FileTest {};

TEST_F(NpzIo, ReadsHalfFloatsByHand) {
  // 0x3C00 = 1, 0xC100 = -2.5, 0x7BFF = 65504, 0x0001 = 2^-24, 0x7C00 = inf, 0x0000 = 0.
  std::string data;
  for (const uint16_t bits : {0x3C00, 0xC100, 0x7BFF, 0x0001, 0x7C00, 0x0000}) data += bytes_of(bits);
  for (const bool compress : {false, true}) {
    const auto arrays = read_npz(write("a.npz", zip("range.npy", npy("<f2", "2, 3", data), compress)));
    ASSERT_EQ(arrays.count("range"), 1u);
    const NpyArray& range = arrays.at("range");
    EXPECT_EQ(range.shape, (std::vector<size_t>{2, 3}));
    EXPECT_EQ(range.values, (std::vector<double>{1, -2.5, 65504, std::ldexp(1.0, -24), INFINITY, 0}));
  }
}

TEST_F(NpzIo, ReadsScalarsAndVectorsOfOtherTypes) {
  const auto scalar = read_npz(write("a.npz", zip("step.npy", npy("<i8", "", bytes_of<int64_t>(-4)), false)));
  EXPECT_TRUE(scalar.at("step").shape.empty());
  EXPECT_EQ(scalar.at("step").values, std::vector<double>{-4});
  const auto vector = read_npz(write("b.npz", zip("v.npy", npy("<f8", "2,", bytes_of(0.5) + bytes_of(-3.0)), false)));
  EXPECT_EQ(vector.at("v").shape, std::vector<size_t>{2});
  EXPECT_EQ(vector.at("v").values, (std::vector<double>{0.5, -3.0}));
}

TEST_F(NpzIo, RefusesWhatItCannotRead) {
  const std::string data = bytes_of<double>(1) + bytes_of<double>(2);
  const std::string good = zip("v.npy", npy("<f8", "2,", data), false);
  EXPECT_ERROR(read_npz(path("none.npz")), "none.npz");
  EXPECT_ERROR(read_npz(write("text.npz", "hello")), "not a zip archive");
  EXPECT_ERROR(read_npz(write("cut.npz", good.substr(0, good.size() - 30))), "not a zip archive");
  std::string damaged = good;
  damaged[150] ^= 1;  // inside the data
  EXPECT_ERROR(read_npz(write("damaged.npz", damaged)), "checksum");
  EXPECT_ERROR(read_npz(write("big.npz", zip("v.npy", npy("<f8", "900000,", data), false))), "larger than the data");
  EXPECT_ERROR(read_npz(write("short.npz", zip("v.npy", npy("<f8", "3,", data), false))), "truncated");
  EXPECT_ERROR(read_npz(write("type.npz", zip("v.npy", npy(">f8", "2,", data), false))), ">f8");
  EXPECT_ERROR(read_npz(write("order.npz", zip("v.npy", npy("<f8", "2,", data, "True"), false))), "Fortran");
}

TEST_F(NpzIo, ReadsTheRangesOfAScene) {
  const std::string file = std::string(CPPLUS_DATA_DIR) + "/truth/corner_4/truth/depth/000000.npz";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no scenes in " << CPPLUS_DATA_DIR;
  const auto arrays = read_npz(file);
  EXPECT_EQ(arrays.at("range").shape, (std::vector<size_t>{192, 256}));
  EXPECT_NEAR(arrays.at("range").values[0], 3.95, 0.005);
  EXPECT_EQ(arrays.at("step").values, std::vector<double>{4});
  EXPECT_EQ(arrays.at("offset").values, std::vector<double>{2});
}

}  // namespace
}  // namespace cpplus
