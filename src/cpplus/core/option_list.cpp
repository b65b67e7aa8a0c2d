#include "cpplus/core/option_list.h"

#include <fmt/format.h>

#include <charconv>

#include "cpplus/core/error.h"

namespace cpplus {

namespace {

template <typename Number>
bool parse_number(const std::string& text, Number* number) {
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, *number);
  return error == std::errc() && rest == end;
}

bool parse(const std::string& text, int* value) { return parse_number(text, value); }
bool parse(const std::string& text, double* value) { return parse_number(text, value); }

bool parse(const std::string& text, std::string* value) {
  *value = text;
  return true;
}

bool parse(const std::string& text, bool* value) {
  *value = text == "true";
  return text == "true" || text == "false";
}

std::string type_name(const bool*) { return "true or false"; }
std::string type_name(const int*) { return "a whole number"; }
std::string type_name(const double*) { return "a number"; }
std::string type_name(const std::string*) { return "text"; }

}  // namespace

std::string option_type(const OptionField& field) {
  return std::visit([](const auto* value) { return type_name(value); }, field.value);
}

std::string option_text(const OptionField& field) {
  return std::visit([](const auto* value) { return fmt::format("{}", *value); }, field.value);
}

void set_option(const OptionField& field, const std::string& name, const std::string& text) {
  const auto set = [&](auto* target) {
    auto value = *target;
    if (!parse(text, &value)) throw UsageError(fmt::format("{} must be {}, got '{}'", name, option_type(field), text));
    *target = value;
  };
  std::visit(set, field.value);
}

}  // namespace cpplus
