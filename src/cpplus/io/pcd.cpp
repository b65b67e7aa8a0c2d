#include "cpplus/io/pcd.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/lzf.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

/// The header's lines as they stand, before they are checked against each other.
struct RawHeader {
  std::vector<std::string> names, sizes, types, counts;
  std::optional<uint64_t> width, height, points;
  std::string data;
};

std::vector<std::string> to_strings(const std::vector<std::string_view>& words) {
  return {words.begin() + 1, words.end()};
}

RawHeader read_raw_header(BlockReader* reader) {
  RawHeader header;
  std::string_view line;
  std::vector<std::string_view> words;
  constexpr uint64_t kMaxHeaderSize = uint64_t{1} << 20;
  while (header.data.empty()) {
    if (reader->position() > kMaxHeaderSize || !reader->take_line(&line)) {
      throw Error(fmt::format("{}: not a PCD file: no DATA line in its header", reader->path()));
    }
    split_words(line, &words);
    if (words.empty() || words[0].starts_with('#')) continue;
    const auto number = [&]() {
      const std::optional<uint64_t> value = words.size() == 2 ? parse_uint(words[1]) : std::nullopt;
      if (!value) throw Error(fmt::format("{}: PCD header: bad line {}", reader->path(), in_quotes(line)));
      return value;
    };
    const std::string key(words[0]);
    if (key == "FIELDS" || key == "COLUMNS") {
      header.names = to_strings(words);
    } else if (key == "SIZE") {
      header.sizes = to_strings(words);
    } else if (key == "TYPE") {
      header.types = to_strings(words);
    } else if (key == "COUNT") {
      header.counts = to_strings(words);
    } else if (key == "WIDTH") {
      header.width = number();
    } else if (key == "HEIGHT") {
      header.height = number();
    } else if (key == "POINTS") {
      header.points = number();
    } else if (key == "DATA") {
      header.data = words.size() == 2 ? std::string(words[1]) : "(none)";
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      throw Error(fmt::format("{}: not a PCD file: unknown header line {}", reader->path(), in_quotes(line)));
    }
  }
  return header;
}

ScalarType scalar_type(const std::string& path, const std::string& type, const std::string& size) {
  const std::string key = type + size;
  if (key == "F4") return ScalarType::kFloat32;
  if (key == "F8") return ScalarType::kFloat64;
  if (key == "I1") return ScalarType::kInt8;
  if (key == "I2") return ScalarType::kInt16;
  if (key == "I4") return ScalarType::kInt32;
  if (key == "I8") return ScalarType::kInt64;
  if (key == "U1") return ScalarType::kUint8;
  if (key == "U2") return ScalarType::kUint16;
  if (key == "U4") return ScalarType::kUint32;
  if (key == "U8") return ScalarType::kUint64;
  throw Error(
      fmt::format("{}: PCD header: no such field type: TYPE {} with SIZE {}", path, in_quotes(type), in_quotes(size)));
}

size_t count_points(const std::string& path, const RawHeader& raw) {
  if (!raw.points && !raw.width) throw Error(fmt::format("{}: PCD header: neither POINTS nor WIDTH", path));
  const uint64_t width = raw.width.value_or(raw.points.value_or(0));
  const uint64_t height = raw.height.value_or(1);
  constexpr uint64_t kMaxSide = uint64_t{1} << 31;
  if (width > kMaxSide || height > kMaxSide) {
    throw Error(fmt::format("{}: PCD header: WIDTH {} x HEIGHT {} is not plausible", path, width, height));
  }
  if (raw.points && *raw.points != width * height) {
    throw Error(fmt::format("{}: PCD header: POINTS {} is not WIDTH {} x HEIGHT {}", path, *raw.points, width, height));
  }
  return width * height;
}

/// A header must not make us reserve memory for points that the file cannot hold.
void check_size(const BlockReader& reader, const PcdHeader& header) {
  uint64_t available = reader.remaining();
  uint64_t smallest = header.record_size;
  if (header.encoding == PcdHeader::Encoding::kAscii) {
    // A number takes a digit and a separator; the last line may lack its newline.
    smallest = 0;
    for (const PointField& field : header.fields) smallest += 2 * field.count;
    available += 1;
  } else if (header.encoding == PcdHeader::Encoding::kBinaryCompressed) {
    constexpr uint64_t kMaxExpansion = 88;  // LZF makes at most 264 bytes out of three
    available *= kMaxExpansion;
  }
  if (smallest > 0 && header.num_points > available / smallest) {
    throw Error(fmt::format("{}: truncated: POINTS {} do not fit into the {} bytes after the header", reader.path(),
                            header.num_points, reader.remaining()));
  }
}

class AsciiSource : public CloudSource {
 public:
  AsciiSource(BlockReader reader, PcdHeader header) : reader_(std::move(reader)), header_(std::move(header)) {
    for (const PointField& field : header_.fields) num_words_ += field.count;
  }

  size_t num_points() const override { return header_.num_points; }
  const std::vector<PointField>& fields() const override { return header_.fields; }

  void read(size_t count, CloudBuilder* builder) override {
    for (size_t point = 0; point < count; ++point, ++next_) {
      if (!take_words()) {
        throw Error(
            fmt::format("{}: truncated: {} points instead of POINTS {}", reader_.path(), next_, header_.num_points));
      }
      if (words_.size() != num_words_) {
        throw Error(fmt::format("{}:{}: {} numbers instead of {}", reader_.path(), reader_.line_number(), words_.size(),
                                num_words_));
      }
      set(point, builder);
    }
    if (next_ == header_.num_points && take_words()) {
      throw Error(fmt::format("{}:{}: more points than POINTS {} says", reader_.path(), reader_.line_number(), next_));
    }
  }

 private:
  /// The words of the next line that is neither empty nor a comment; false at the end of the file.
  bool take_words() {
    std::string_view line;
    while (reader_.take_line(&line)) {
      split_words(line, &words_);
      if (!words_.empty() && !words_[0].starts_with('#')) return true;
    }
    return false;
  }

  void set(size_t point, CloudBuilder* builder) const {
    size_t word = 0;
    for (const PointField& field : header_.fields) {
      const std::string_view text = words_[word];
      word += field.count;
      if (field.role == PointRole::kNone) continue;
      const std::optional<double> value = parse_double(text);
      if (!value) {
        throw Error(fmt::format("{}:{}: {} is not a number: {}", reader_.path(), reader_.line_number(), field.name,
                                in_quotes(text)));
      }
      // Older writers print a packed colour as the float that its bits make; plain digits are the integer itself.
      if (field.role == PointRole::kPackedRgb && text.find_first_of(".eEn") != std::string_view::npos) {
        builder->set_packed_rgb(point, std::bit_cast<uint32_t>(static_cast<float>(*value)));
      } else {
        builder->set(point, field.role, converted(field, *value));
      }
    }
  }

  BlockReader reader_;
  PcdHeader header_;
  size_t num_words_ = 0;
  size_t next_ = 0;
  std::vector<std::string_view> words_;
};

class BinarySource : public CloudSource {
 public:
  BinarySource(BlockReader reader, PcdHeader header) : reader_(std::move(reader)), header_(std::move(header)) {}

  size_t num_points() const override { return header_.num_points; }
  const std::vector<PointField>& fields() const override { return header_.fields; }

  void read(size_t count, CloudBuilder* builder) override {
    constexpr size_t kBlockSize = size_t{1} << 18;
    const size_t block = std::max<size_t>(1, kBlockSize / std::max<size_t>(1, header_.record_size));
    for (size_t first = 0; first < count; first += block) {
      const size_t size = std::min(block, count - first);
      const uint8_t* records = reader_.take(size * header_.record_size);
      for (const PointField& field : header_.fields) {
        if (field.role == PointRole::kNone) continue;
        builder->set_column(first, size, field, records + field.offset, header_.record_size);
      }
    }
  }

 private:
  BlockReader reader_;
  PcdHeader header_;
};

/// One field of a compressed file: the decoded data holds the fields one after the other, each for all points.
class CompressedColumn {
 public:
  CompressedColumn(const std::string& path, uint64_t data_offset, uint64_t compressed_size)
      : reader_(path), decoder_(&reader_, compressed_size), data_offset_(data_offset) {}
  CompressedColumn(const CompressedColumn&) = delete;
  CompressedColumn& operator=(const CompressedColumn&) = delete;

  /// Goes to `decoded_offset`: there is no way there but by decoding what comes before.
  void skip_to(uint64_t decoded_offset) {
    reader_.skip(data_offset_);
    std::vector<uint8_t> ignored(1 << 16);
    for (uint64_t left = decoded_offset; left > 0;) {
      const size_t step = static_cast<size_t>(std::min<uint64_t>(left, ignored.size()));
      decoder_.decode(ignored.data(), step);
      left -= step;
    }
  }

  /// Sets the field in the next `count` points, or passes over it where it means nothing.
  void read(const PointField& field, size_t count, CloudBuilder* builder) {
    value_.resize(field.count * scalar_size(field.type));
    for (size_t point = 0; point < count; ++point) {
      decoder_.decode(value_.data(), value_.size());
      if (field.role != PointRole::kNone) builder->set_from_bytes(point, field, value_.data(), false);
    }
  }

 private:
  BlockReader reader_;
  LzfDecoder decoder_;
  uint64_t data_offset_;
  std::vector<uint8_t> value_;
};

class CompressedSource : public CloudSource {
 public:
  CompressedSource(BlockReader reader, PcdHeader header) : path_(reader.path()), header_(std::move(header)) {
    const auto take_size = [&]() {
      return static_cast<uint64_t>(load_scalar(reader.take(4), ScalarType::kUint32, false));
    };
    compressed_size_ = take_size();
    const uint64_t decoded_size = take_size();
    if (compressed_size_ > reader.remaining()) {
      throw Error(fmt::format("{}: truncated: {} compressed bytes announced, {} left in the file", path_,
                              compressed_size_, reader.remaining()));
    }
    if (decoded_size != header_.num_points * header_.record_size) {
      throw Error(fmt::format("{}: decoded size {} is not POINTS {} of {} bytes", path_, decoded_size,
                              header_.num_points, header_.record_size));
    }
    data_offset_ = reader.position();
  }

  size_t num_points() const override { return header_.num_points; }
  const std::vector<PointField>& fields() const override { return header_.fields; }

  /// All points at once are decoded in one go; blocks of them by one decoder a field, each of which has to decode what
  /// comes before its field first.
  void read(size_t count, CloudBuilder* builder) override {
    if (count == header_.num_points) {
      CompressedColumn all(path_, data_offset_, compressed_size_);
      all.skip_to(0);
      for (const PointField& field : header_.fields) all.read(field, count, builder);
      return;
    }
    if (columns_.empty()) open_columns();
    for (size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i]) columns_[i]->read(header_.fields[i], count, builder);
    }
  }

 private:
  void open_columns() {
    for (const PointField& field : header_.fields) {
      columns_.push_back(nullptr);
      if (field.role == PointRole::kNone) continue;
      columns_.back() = std::make_unique<CompressedColumn>(path_, data_offset_, compressed_size_);
      columns_.back()->skip_to(header_.num_points * field.offset);
    }
  }

  std::string path_;
  PcdHeader header_;
  uint64_t compressed_size_ = 0;
  uint64_t data_offset_ = 0;
  std::vector<std::unique_ptr<CompressedColumn>> columns_;
};

}  // namespace

PcdHeader read_pcd_header(BlockReader* reader) {
  const RawHeader raw = read_raw_header(reader);
  const std::string& path = reader->path();
  const size_t num_fields = raw.names.size();
  if (num_fields == 0) throw Error(fmt::format("{}: PCD header: no FIELDS", path));
  if (raw.sizes.size() != num_fields || raw.types.size() != num_fields ||
      (!raw.counts.empty() && raw.counts.size() != num_fields)) {
    throw Error(fmt::format("{}: PCD header: {} FIELDS but {} SIZE, {} TYPE, {} COUNT", path, num_fields,
                            raw.sizes.size(), raw.types.size(), raw.counts.size()));
  }
  PcdHeader header;
  for (size_t i = 0; i < num_fields; ++i) {
    PointField field{raw.names[i], scalar_type(path, raw.types[i], raw.sizes[i]), 1, header.record_size,
                     PointRole::kNone};
    if (!raw.counts.empty()) {
      const std::optional<uint64_t> count = parse_uint(raw.counts[i]);
      constexpr uint64_t kMaxCount = uint64_t{1} << 20;
      if (!count || *count > kMaxCount) {
        throw Error(fmt::format("{}: PCD header: bad COUNT {} of {}", path, in_quotes(raw.counts[i]), field.name));
      }
      field.count = *count;
    }
    header.record_size += field.count * scalar_size(field.type);
    header.fields.push_back(field);
  }
  assign_roles(&header.fields);
  header.num_points = count_points(path, raw);
  if (raw.data == "ascii") {
    header.encoding = PcdHeader::Encoding::kAscii;
  } else if (raw.data == "binary") {
    header.encoding = PcdHeader::Encoding::kBinary;
  } else if (raw.data == "binary_compressed") {
    header.encoding = PcdHeader::Encoding::kBinaryCompressed;
  } else {
    throw Error(fmt::format("{}: PCD header: unknown DATA {}", path, in_quotes(raw.data)));
  }
  check_size(*reader, header);
  return header;
}

std::unique_ptr<CloudSource> open_pcd(const std::string& path) {
  BlockReader reader(path);
  PcdHeader header = read_pcd_header(&reader);
  switch (header.encoding) {
    case PcdHeader::Encoding::kAscii:
      return std::make_unique<AsciiSource>(std::move(reader), std::move(header));
    case PcdHeader::Encoding::kBinary:
      return std::make_unique<BinarySource>(std::move(reader), std::move(header));
    case PcdHeader::Encoding::kBinaryCompressed:
      return std::make_unique<CompressedSource>(std::move(reader), std::move(header));
  }
  throw Error(fmt::format("{}: PCD header: unknown DATA", path));
}

}  // namespace cpplus
