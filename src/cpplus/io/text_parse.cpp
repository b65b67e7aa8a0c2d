#include "cpplus/io/text_parse.h"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace cpplus {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

template <typename Number>
std::optional<Number> parse(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  Number value{};
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (failure != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return value;
}

}  // namespace

std::string_view trim(std::string_view text) {
  const size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::string_view next_word(std::string_view* text) {
  const size_t begin = std::min(text->find_first_not_of(kBlanks), text->size());
  const size_t end = std::min(text->find_first_of(kBlanks, begin), text->size());
  const std::string_view word = text->substr(begin, end - begin);
  text->remove_prefix(end);
  return word;
}

void split_words(std::string_view text, std::vector<std::string_view>* words) {
  words->clear();
  for (std::string_view word = next_word(&text); !word.empty(); word = next_word(&text)) words->push_back(word);
}

void split_at_commas(std::string_view text, std::vector<std::string_view>* parts) {
  parts->clear();
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    parts->push_back(trim(text.substr(begin, end - begin)));
    begin = end + 1;
  }
}

std::optional<double> parse_double(std::string_view word) { return parse<double>(word); }
std::optional<int64_t> parse_int(std::string_view word) { return parse<int64_t>(word); }
std::optional<uint64_t> parse_uint(std::string_view word) { return parse<uint64_t>(word); }

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return lower;
}

std::string in_quotes(std::string_view word) {
  constexpr size_t kMaxShown = 60;
  std::string shown = "'";
  for (const char c : word.substr(0, kMaxShown)) shown += std::isprint(static_cast<unsigned char>(c)) ? c : '?';
  return shown + (word.size() > kMaxShown ? "...'" : "'");
}

}  // namespace cpplus
