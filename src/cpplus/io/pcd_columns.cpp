#include "cpplus/io/pcd_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/pcd.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

struct Column {
  PointField field;
  size_t word = 0;  // its place in a line of an ascii file
};

std::vector<Column> find_columns(const PcdHeader& header, const std::string& path,
                                 const std::vector<std::string>& names) {
  std::vector<Column> columns;
  for (const std::string& name : names) {
    size_t word = 0;
    std::optional<Column> column;
    for (const PointField& field : header.fields) {
      if (field.name == name && field.count == 1) column = Column{field, word};
      word += field.count;
    }
    if (!column) throw Error(fmt::format("{}: has no field {}", path, name));
    columns.push_back(*column);
  }
  return columns;
}

double word_number(const BlockReader& reader, const std::vector<std::string_view>& words, const Column& column) {
  const std::optional<double> value =
      column.word < words.size() ? parse_double(words[column.word]) : std::optional<double>();
  if (!value)
    throw Error(fmt::format("{}:{}: {} is not a number", reader.path(), reader.line_number(), column.field.name));
  return *value;
}

}  // namespace

std::vector<std::vector<double>> read_pcd_columns(const std::string& path, const std::vector<std::string>& names) {
  BlockReader reader(path);
  const PcdHeader header = read_pcd_header(&reader);
  const std::vector<Column> columns = find_columns(header, path, names);
  std::vector<std::vector<double>> values(names.size());
  if (header.encoding == PcdHeader::Encoding::kBinaryCompressed) {
    throw Error(fmt::format("{}: is compressed; poses are read from ascii and binary files", path));
  }
  std::string_view line;
  std::vector<std::string_view> words;
  for (size_t point = 0; point < header.num_points; ++point) {
    if (header.encoding == PcdHeader::Encoding::kBinary) {
      const uint8_t* record = reader.take(header.record_size);
      for (size_t i = 0; i < columns.size(); ++i) {
        values[i].push_back(load_scalar(record + columns[i].field.offset, columns[i].field.type, false));
      }
      continue;
    }
    if (!reader.take_line(&line)) {
      throw Error(fmt::format("{}: truncated: {} points instead of POINTS {}", path, point, header.num_points));
    }
    split_words(line, &words);
    for (size_t i = 0; i < columns.size(); ++i) values[i].push_back(word_number(reader, words, columns[i]));
  }
  return values;
}

}  // namespace cpplus
