#include "cpplus/io/stamps_io.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {

std::map<std::string, double> read_stamps(const std::string& path) {
  BlockReader reader(path);
  std::map<std::string, double> stamps;
  std::string_view line;
  while (reader.take_line(&line)) {
    line = trim(line);
    if (line.empty() || line.front() == '#') continue;
    const size_t blank = line.find_last_of(" \t");
    const std::string_view last_word = line.substr(blank == std::string_view::npos ? 0 : blank + 1);
    const std::optional<double> stamp = parse_double(last_word);
    if (blank == std::string_view::npos || !stamp || !std::isfinite(*stamp)) {
      throw Error(fmt::format("{}:{}: not `name seconds`: {}", path, reader.line_number(), in_quotes(line)));
    }
    const std::string name(trim(line.substr(0, blank)));
    if (!stamps.emplace(name, *stamp).second) {
      throw Error(fmt::format("{}:{}: {} occurs twice", path, reader.line_number(), in_quotes(name)));
    }
  }
  if (stamps.empty()) throw Error(fmt::format("{}: holds no stamps", path));
  return stamps;
}

}  // namespace cpplus
