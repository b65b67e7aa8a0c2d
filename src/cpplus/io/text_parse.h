#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cpplus {

/// The text without blanks at both ends.
std::string_view trim(std::string_view text);

/// Cuts the first word (at blanks and tabs) off the text; empty when there is none.
std::string_view next_word(std::string_view* text);

void split_words(std::string_view text, std::vector<std::string_view>* words);

/// The parts between commas, without blanks at their ends; an empty text has one empty part.
void split_at_commas(std::string_view text, std::vector<std::string_view>* parts);

/// The whole word as a number, whatever the locale; nothing when it is not one. "nan" and "inf" are numbers.
std::optional<double> parse_double(std::string_view word);
std::optional<int64_t> parse_int(std::string_view word);
std::optional<uint64_t> parse_uint(std::string_view word);

std::string lower_case(std::string_view text);

/// The word for an error message: shortened when long, unprintable bytes as '?'. Messages stay one line.
std::string in_quotes(std::string_view word);

}  // namespace cpplus
