#include "cpplus/io/options_yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "cpplus/core/error.h"

namespace cpplus {

namespace {

using FieldsByPath = std::map<std::string, const OptionField*>;

bool is_group(const FieldsByPath& fields, const std::string& path) {
  const auto next = fields.lower_bound(path + ".");
  return next != fields.end() && next->first.starts_with(path + ".");
}

void set_field(const std::string& file, const OptionField& field, const YAML::Node& node) {
  const std::string name = fmt::format("{}: {}", file, field.path);
  if (!node.IsScalar())
    throw UsageError(fmt::format("{} must be {}, got {}", name, option_type(field),
                                 node.IsMap()    ? "a group of keys"
                                 : node.IsNull() ? "nothing"
                                                 : "a list"));
  set_option(field, name, node.Scalar());
}

void set_fields(const std::string& file, const FieldsByPath& fields, const std::string& prefix,
                const YAML::Node& node) {
  std::set<std::string> seen;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar())
      throw UsageError(fmt::format("{}: line {}: a key must be text", file, entry.first.Mark().line + 1));
    const std::string path = prefix + entry.first.Scalar();
    if (!seen.insert(path).second) throw UsageError(fmt::format("{}: key '{}' is given twice", file, path));
    const auto field = fields.find(path);
    if (field != fields.end()) {
      set_field(file, *field->second, entry.second);
    } else if (!is_group(fields, path)) {
      throw UsageError(fmt::format("{}: unknown key '{}'", file, path));
    } else if (entry.second.IsMap()) {
      set_fields(file, fields, path + ".", entry.second);
    } else if (!entry.second.IsNull()) {
      throw UsageError(fmt::format("{}: '{}' must be a group of keys", file, path));
    }
  }
}

YAML::Node load_yaml(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  if (std::filesystem::is_directory(file) || !(text << stream.rdbuf())) {
    // An empty file also fails to stream; it is valid YAML without keys.
    if (std::filesystem::is_regular_file(file) && std::filesystem::is_empty(file)) return {};
    throw UsageError(fmt::format("{}: cannot be read", file.string()));
  }
  try {
    return YAML::Load(text.str());
  } catch (const YAML::Exception& error) {
    throw UsageError(fmt::format("{}: line {}: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream stream(path);
  for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
  return parts;
}

std::string yaml_value(const OptionField& field) {
  std::string text = option_text(field);
  if (!std::holds_alternative<std::string*>(field.value)) return text;
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

}  // namespace

void read_options_yaml(const std::filesystem::path& file, const std::vector<OptionField>& fields) {
  FieldsByPath fields_by_path;
  for (const OptionField& field : fields) fields_by_path[field.path] = &field;
  const YAML::Node root = load_yaml(file);
  if (!root.IsDefined() || root.IsNull()) return;
  if (!root.IsMap()) throw UsageError(fmt::format("{}: must be a group of keys", file.string()));
  set_fields(file.string(), fields_by_path, "", root);
}

std::string options_to_yaml(const std::vector<OptionField>& fields) {
  std::string yaml;
  std::vector<std::string> groups;  // the open ones
  for (const OptionField& field : fields) {
    std::vector<std::string> parts = split(field.path);
    const std::string name = parts.back();
    parts.pop_back();
    size_t common = 0;
    while (common < groups.size() && common < parts.size() && groups[common] == parts[common]) ++common;
    for (size_t depth = common; depth < parts.size(); ++depth) {
      yaml += fmt::format("{:{}}{}:\n", "", 2 * depth, parts[depth]);
    }
    groups = parts;
    yaml += fmt::format("{0:{1}}# {2}\n{0:{1}}{3}: {4}\n", "", 2 * groups.size(), field.doc, name, yaml_value(field));
  }
  return yaml;
}

}  // namespace cpplus
