#include "cpplus/io/ply.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/byte_writer.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

using Encoding = PlyHeader::Encoding;

/// The elements as they stand in the header.
struct RawHeader {
  std::string format;
  std::vector<PlyElement> elements;
};

ScalarType scalar_type(const BlockReader& reader, std::string_view name) {
  if (name == "char" || name == "int8") return ScalarType::kInt8;
  if (name == "uchar" || name == "uint8") return ScalarType::kUint8;
  if (name == "short" || name == "int16") return ScalarType::kInt16;
  if (name == "ushort" || name == "uint16") return ScalarType::kUint16;
  if (name == "int" || name == "int32") return ScalarType::kInt32;
  if (name == "uint" || name == "uint32") return ScalarType::kUint32;
  if (name == "float" || name == "float32") return ScalarType::kFloat32;
  if (name == "double" || name == "float64") return ScalarType::kFloat64;
  throw Error(fmt::format("{}:{}: no such PLY type: {}", reader.path(), reader.line_number(), in_quotes(name)));
}

PlyProperty parse_property(const BlockReader& reader, const std::vector<std::string_view>& words) {
  PlyProperty property;
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (is_list) {
    property.list_size_type = scalar_type(reader, words[2]);
    if (is_floating(*property.list_size_type)) {
      throw Error(fmt::format("{}:{}: a list's length cannot be a {}", reader.path(), reader.line_number(), words[2]));
    }
  }
  property.field.type = scalar_type(reader, words[is_list ? 3 : 1]);
  property.field.name = words.back();
  return property;
}

RawHeader read_raw_header(BlockReader* reader) {
  RawHeader header;
  std::string_view line;
  if (!reader->take_line(&line) || trim(line) != "ply") {
    throw Error(fmt::format("{}: not a PLY file: it does not begin with 'ply'", reader->path()));
  }
  std::vector<std::string_view> words;
  constexpr uint64_t kMaxHeaderSize = uint64_t{1} << 20;
  while (true) {
    if (reader->position() > kMaxHeaderSize || !reader->take_line(&line)) {
      throw Error(fmt::format("{}: the PLY header has no end_header", reader->path()));
    }
    split_words(line, &words);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") return header;
    if (words[0] == "format" && words.size() == 3) {
      header.format = words[1];
    } else if (words[0] == "element" && words.size() == 3 && parse_uint(words[2])) {
      header.elements.push_back({std::string(words[1]), *parse_uint(words[2]), {}});
    } else if (words[0] == "property" && words.size() >= 3 && !header.elements.empty()) {
      header.elements.back().properties.push_back(parse_property(*reader, words));
    } else {
      throw Error(fmt::format("{}:{}: bad PLY header line {}", reader->path(), reader->line_number(), in_quotes(line)));
    }
  }
}

/// A header must not make us reserve memory for records that the file cannot hold.
void check_size(const BlockReader& reader, Encoding encoding, const PlyElement& element) {
  uint64_t smallest = 0;
  for (const PlyProperty& property : element.properties) {
    smallest += encoding == Encoding::kAscii ? 2 : scalar_size(property.list_size_type.value_or(property.field.type));
  }
  // The last line of an ASCII file may lack its newline.
  const uint64_t available = reader.remaining() + (encoding == Encoding::kAscii ? 1 : 0);
  if (smallest > 0 && element.count > available / smallest) {
    throw Error(fmt::format("{}: truncated: element {} {} does not fit into the {} bytes after the header",
                            reader.path(), element.name, element.count, reader.remaining()));
  }
}

/// Takes one binary record, list by list; a null builder skips it.
void take_binary_record(const PlyElement& element, const std::vector<PointField>& fields, bool big_endian, size_t point,
                        BlockReader* reader, CloudBuilder* builder) {
  size_t next_field = 0;
  for (const PlyProperty& property : element.properties) {
    const size_t item_size = scalar_size(property.field.type);
    if (property.list_size_type) {
      const ScalarType type = *property.list_size_type;
      const double length = load_scalar(reader->take(scalar_size(type)), type, big_endian);
      if (length < 0) throw Error(fmt::format("{}: a list of {} has {} items", reader->path(), element.name, length));
      reader->skip(static_cast<uint64_t>(length) * item_size);
      continue;
    }
    const uint8_t* data = reader->take(item_size);
    if (builder == nullptr) continue;
    const PointField& field = fields[next_field++];
    if (field.role != PointRole::kNone) builder->set_from_bytes(point, field, data, big_endian);
  }
}

void read_binary(const PlyHeader& header, size_t count, BlockReader* reader, CloudBuilder* builder) {
  const bool big_endian = header.encoding == Encoding::kBigEndian;
  const bool has_lists = header.fields.size() < header.vertices.properties.size();
  const size_t record_size = header.fields.back().offset + scalar_size(header.fields.back().type);
  for (size_t point = 0; point < count; ++point) {
    if (has_lists) {
      take_binary_record(header.vertices, header.fields, big_endian, point, reader, builder);
      continue;
    }
    const uint8_t* record = reader->take(record_size);
    for (const PointField& field : header.fields) {
      if (field.role != PointRole::kNone) builder->set_from_bytes(point, field, record + field.offset, big_endian);
    }
  }
}

/// The words of the next line that is not empty.
void take_ascii_record(BlockReader* reader, const PlyElement& element, uint64_t index,
                       std::vector<std::string_view>* words) {
  std::string_view line;
  do {
    if (!reader->take_line(&line)) {
      throw Error(fmt::format("{}: truncated: {} of {} lines of element {}", reader->path(), index, element.count,
                              element.name));
    }
    split_words(line, words);
  } while (words->empty());
}

void set_ascii_record(const PlyHeader& header, const std::vector<std::string_view>& words, size_t point,
                      const BlockReader& reader, CloudBuilder* builder) {
  const auto fail = [&](const std::string& what) {
    throw Error(fmt::format("{}:{}: {}", reader.path(), reader.line_number(), what));
  };
  size_t word = 0;
  size_t next_field = 0;
  for (const PlyProperty& property : header.vertices.properties) {
    if (word >= words.size()) fail(fmt::format("{} numbers are too few for a vertex", words.size()));
    const std::string_view text = words[word++];
    if (property.list_size_type) {
      const std::optional<uint64_t> length = parse_uint(text);
      if (!length || *length > words.size() - word) fail(fmt::format("bad list length {}", in_quotes(text)));
      word += *length;
      continue;
    }
    const PointField& field = header.fields[next_field++];
    if (field.role == PointRole::kNone) continue;
    const std::optional<double> value = parse_double(text);
    if (!value) fail(fmt::format("{} is not a number: {}", field.name, in_quotes(text)));
    builder->set(point, field.role, converted(field, *value));
  }
  if (word != words.size()) fail(fmt::format("{} numbers are too many for a vertex", words.size()));
}

class PlySource : public CloudSource {
 public:
  explicit PlySource(const std::string& path) : reader_(path), header_(read_ply_header(&reader_)) {}

  size_t num_points() const override { return header_.vertices.count; }
  const std::vector<PointField>& fields() const override { return header_.fields; }

  void read(size_t count, CloudBuilder* builder) override {
    if (!at_vertices_) skip_elements();
    at_vertices_ = true;
    if (header_.encoding != Encoding::kAscii) return read_binary(header_, count, &reader_, builder);
    std::vector<std::string_view> words;
    for (size_t point = 0; point < count; ++point) {
      take_ascii_record(&reader_, header_.vertices, next_++, &words);
      set_ascii_record(header_, words, point, reader_, builder);
    }
  }

 private:
  void skip_elements() {
    std::vector<std::string_view> words;
    for (const PlyElement& element : header_.before_vertices) {
      for (uint64_t i = 0; i < element.count; ++i) {
        if (header_.encoding == Encoding::kAscii) {
          take_ascii_record(&reader_, element, i, &words);
        } else {
          take_binary_record(element, {}, header_.encoding == Encoding::kBigEndian, 0, &reader_, nullptr);
        }
      }
    }
  }

  BlockReader reader_;
  PlyHeader header_;
  bool at_vertices_ = false;
  uint64_t next_ = 0;  // line of the vertices
};

/// `block`: some of the points.
void write_header(const PointCloud& block, size_t num_points, std::ostream* stream) {
  const bool local = block.origin.isZero(0.0);
  *stream << "ply\nformat binary_little_endian 1.0\nelement vertex " << num_points << "\n";
  for (const char axis : {'x', 'y', 'z'}) *stream << "property " << (local ? "float " : "double ") << axis << "\n";
  if (!block.intensities.empty()) *stream << "property float intensity\n";
  if (!block.colors.empty()) *stream << "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!block.stamps_s.empty()) *stream << "property double timestamp\n";
  if (!block.num_views.empty()) *stream << "property ushort num_views\n";
  if (!block.best_images.empty()) *stream << "property uint best_image\n";
  if (!block.color_spreads.empty()) *stream << "property uchar color_spread\n";
  *stream << "end_header\n";
}

void put_points(const PointCloud& cloud, ByteWriter* writer) {
  const bool local = cloud.origin.isZero(0.0);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = cloud.point(i);
    for (int axis = 0; axis < 3; ++axis) local ? writer->put(cloud.positions[i][axis]) : writer->put(point[axis]);
    if (!cloud.intensities.empty()) writer->put(cloud.intensities[i]);
    if (!cloud.colors.empty()) {
      for (const uint8_t channel : cloud.colors[i]) writer->put(channel);
    }
    if (!cloud.stamps_s.empty()) writer->put(cloud.stamps_s[i]);
    if (!cloud.num_views.empty()) writer->put(cloud.num_views[i]);
    if (!cloud.best_images.empty()) writer->put(cloud.best_images[i]);
    if (!cloud.color_spreads.empty()) writer->put(cloud.color_spreads[i]);
  }
}

}  // namespace

PlyHeader read_ply_header(BlockReader* reader) {
  RawHeader raw = read_raw_header(reader);
  PlyHeader header;
  if (raw.format == "ascii") {
    header.encoding = Encoding::kAscii;
  } else if (raw.format == "binary_little_endian") {
    header.encoding = Encoding::kLittleEndian;
  } else if (raw.format == "binary_big_endian") {
    header.encoding = Encoding::kBigEndian;
  } else {
    throw Error(fmt::format("{}: PLY header: unknown format {}", reader->path(), in_quotes(raw.format)));
  }
  for (PlyElement& element : raw.elements) {
    check_size(*reader, header.encoding, element);
    if (element.name == "vertex") {
      header.vertices = std::move(element);
      break;
    }
    header.before_vertices.push_back(std::move(element));
  }
  if (header.vertices.name.empty()) throw Error(fmt::format("{}: PLY header: no element vertex", reader->path()));
  size_t offset = 0;
  for (const PlyProperty& property : header.vertices.properties) {
    if (property.list_size_type) continue;
    header.fields.push_back(property.field);
    header.fields.back().offset = offset;
    offset += scalar_size(property.field.type);
  }
  assign_roles(&header.fields);
  return header;
}

std::unique_ptr<CloudSource> open_ply(const std::string& path) { return std::make_unique<PlySource>(path); }

void write_ply(const std::string& path, const CloudStream& cloud) {
  AtomicFile file(path);
  ByteWriter writer(&file.stream());
  bool has_header = false;
  cloud.for_each_block([&](const PointCloud& block) {
    if (!has_header) write_header(block, cloud.num_points, &file.stream());
    has_header = true;
    put_points(block, &writer);
  });
  writer.flush();
  file.commit();
}

}  // namespace cpplus
