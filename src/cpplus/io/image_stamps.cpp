#include "cpplus/io/image_stamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool all_digits(std::string_view word) { return !word.empty() && std::all_of(word.begin(), word.end(), is_digit); }

/// The numbers in a text as they are written, with at most one point inside.
std::vector<std::string_view> numbers_in(std::string_view text) {
  std::vector<std::string_view> numbers;
  for (size_t i = 0; i < text.size();) {
    if (!is_digit(text[i])) {
      ++i;
      continue;
    }
    size_t end = i;
    bool has_point = false;
    while (end < text.size()) {
      const bool point = !has_point && text[end] == '.' && end + 1 < text.size() && is_digit(text[end + 1]);
      if (!is_digit(text[end]) && !point) break;
      has_point = has_point || point;
      ++end;
    }
    numbers.push_back(text.substr(i, end - i));
    i = end;
  }
  return numbers;
}

std::string stem_of(const std::string& name) { return std::filesystem::path(name).stem().string(); }

size_t num_digits(std::string_view number) {
  return static_cast<size_t>(std::count_if(number.begin(), number.end(), is_digit));
}

std::string_view longest_number(std::string_view text) {
  std::string_view longest;
  for (const std::string_view number : numbers_in(text)) {
    if (num_digits(number) > num_digits(longest)) longest = number;
  }
  return longest;
}

/// Seconds and nanoseconds as two words.
std::optional<double> split_stamp(std::string_view stem) {
  const std::vector<std::string_view> numbers = numbers_in(stem);
  for (size_t i = 0; i + 1 < numbers.size(); ++i) {
    if (numbers[i].size() != 10 || numbers[i + 1].size() != 9) continue;
    if (!all_digits(numbers[i]) || !all_digits(numbers[i + 1])) continue;
    const char* between = numbers[i].data() + numbers[i].size();
    if (numbers[i + 1].data() != between + 1 || (*between != '_' && *between != '-')) continue;
    return *parse_double(numbers[i]) + 1e-9 * *parse_double(numbers[i + 1]);
  }
  return {};
}

StampUnit unit_of_whole_number(std::string_view word) {
  if (word.size() >= 18) return StampUnit::kNanoseconds;
  if (word.size() >= 15) return StampUnit::kMicroseconds;
  return word.size() >= 12 ? StampUnit::kMilliseconds : StampUnit::kSeconds;
}

double units_per_second(StampUnit unit) {
  switch (unit) {
    case StampUnit::kMilliseconds:
      return 1e3;
    case StampUnit::kMicroseconds:
      return 1e6;
    case StampUnit::kNanoseconds:
      return 1e9;
    case StampUnit::kAuto:
    case StampUnit::kSeconds:
      break;
  }
  return 1.0;
}

struct NamedStamp {
  std::string name;
  std::optional<double> stamp_s;
};

NamedStamp parse_csv_line(std::string_view line, StampUnit unit) {
  NamedStamp named;
  std::vector<std::string_view> columns;
  split_at_commas(line, &columns);
  for (const std::string_view column : columns) {
    const std::optional<double> stamp = parse_stamp(column, unit);
    if (stamp && !named.stamp_s) {
      named.stamp_s = stamp;
    } else if (!stamp && named.name.empty()) {
      named.name = std::string(column);
    }
  }
  return named;
}

NamedStamp parse_blank_line(std::string_view line, StampUnit unit) {
  const size_t last_blank = line.find_last_of(" \t");
  if (last_blank == std::string_view::npos) return {};
  if (const auto stamp = parse_stamp(line.substr(last_blank + 1), unit)) {
    return {std::string(trim(line.substr(0, last_blank))), stamp};
  }
  std::string_view rest = line;
  const std::string_view first = next_word(&rest);
  return {std::string(trim(rest)), parse_stamp(first, unit)};
}

}  // namespace

std::optional<StampUnit> stamp_unit_from_name(const std::string& name) {
  if (name == "auto") return StampUnit::kAuto;
  if (name == "s") return StampUnit::kSeconds;
  if (name == "ms") return StampUnit::kMilliseconds;
  if (name == "us") return StampUnit::kMicroseconds;
  if (name == "ns") return StampUnit::kNanoseconds;
  return {};
}

std::optional<double> parse_stamp(std::string_view word, StampUnit unit) {
  const std::optional<double> number = parse_double(word);
  if (!number || !std::isfinite(*number)) return {};
  if (unit == StampUnit::kAuto && all_digits(word)) unit = unit_of_whole_number(word);
  const double per_second = units_per_second(unit);
  // Whole counts are split, so that nineteen digits lose nothing before the division.
  const std::optional<int64_t> count = parse_int(word);
  if (!count || per_second == 1.0) return *number / per_second;
  const int64_t divisor = static_cast<int64_t>(per_second);
  return static_cast<double>(*count / divisor) + static_cast<double>(*count % divisor) / per_second;
}

std::optional<double> stamp_of_file_name(const std::string& name, StampUnit unit) {
  const std::string stem = stem_of(name);
  if (unit == StampUnit::kAuto) {
    if (const auto stamp = split_stamp(stem)) return stamp;
  }
  const std::string_view number = longest_number(stem);
  if (number.empty()) return {};
  return parse_stamp(number, unit);
}

bool may_be_frame_number(const std::string& name) {
  constexpr size_t kDigitsOfSecondsSince1970 = 10;
  const std::string stem = stem_of(name);
  const std::string_view number = longest_number(stem);
  return all_digits(number) && number.size() < kDigitsOfSecondsSince1970;
}

std::map<std::string, double> read_image_stamps(const std::string& path, StampUnit unit) {
  BlockReader reader(path);
  std::map<std::string, double> stamps;
  std::string_view line;
  bool is_first = true;
  while (reader.take_line(&line)) {
    line = trim(line);
    if (line.empty() || line.front() == '#') continue;
    const bool is_csv = line.find(',') != std::string_view::npos;
    const NamedStamp named = is_csv ? parse_csv_line(line, unit) : parse_blank_line(line, unit);
    const bool is_header = is_first && is_csv && !named.stamp_s;
    is_first = false;
    if (is_header) continue;
    if (named.name.empty() || !named.stamp_s) {
      throw Error(fmt::format("{}:{}: not a name and a stamp: {}", path, reader.line_number(), in_quotes(line)));
    }
    if (!stamps.emplace(named.name, *named.stamp_s).second) {
      throw Error(fmt::format("{}:{}: {} occurs twice", path, reader.line_number(), in_quotes(named.name)));
    }
  }
  if (stamps.empty()) throw Error(fmt::format("{}: holds no stamps", path));
  return stamps;
}

}  // namespace cpplus
