#pragma once

#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace cpplus {

/// One field of an options struct, by its path ("visibility.max_distance_m") and a pointer to it.
struct OptionField {
  std::string path;
  std::string doc;
  std::variant<bool*, int*, double*, std::string*> value;
};

/// The visitor (core/options.h) that flattens an options struct and its groups into a list of fields.
class OptionLister {
 public:
  OptionLister(std::string prefix, std::vector<OptionField>* fields) : prefix_(std::move(prefix)), fields_(fields) {}

  template <typename Field>
  void operator()(const char* name, Field& field, const char* doc) {
    fields_->push_back({prefix_ + name, doc, &field});
  }

  template <typename Options>
  void group(const char* name, Options& options) {
    OptionLister lister(prefix_ + name + ".", fields_);
    options.visit(lister);
  }

 private:
  std::string prefix_;
  std::vector<OptionField>* fields_;
};

/// The fields of `options` in the order of their declaration, groups included. The pointers are into `options`. A
/// non-empty `prefix` goes before each path, with a dot.
template <typename Options>
std::vector<OptionField> list_options(Options& options, const std::string& prefix = "") {
  static_assert(!std::is_const_v<Options>, "copy the options to list them");
  std::vector<OptionField> fields;
  OptionLister lister(prefix.empty() ? "" : prefix + ".", &fields);
  options.visit(lister);
  return fields;
}

/// "a number", "a whole number", "true or false" or "text": what set_option accepts for the field.
std::string option_type(const OptionField& field);

/// The value as text that set_option reads back to the same value (shortest form for numbers).
std::string option_text(const OptionField& field);

/// Sets the field from text. Throws UsageError "NAME must be a number, got 'TEXT'", where NAME is how the user knows
/// the field.
void set_option(const OptionField& field, const std::string& name, const std::string& text);

}  // namespace cpplus
