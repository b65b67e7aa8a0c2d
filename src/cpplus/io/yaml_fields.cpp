#include "cpplus/io/yaml_fields.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "cpplus/core/error.h"
#include "cpplus/io/rotation_check.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

void append_numbers(const YAML::Node& node, const std::string& where, std::vector<double>* numbers) {
  if (node.IsSequence()) {
    for (const YAML::Node& child : node) append_numbers(child, where, numbers);
  } else {
    numbers->push_back(yaml_number(node, where));
  }
}

Rigid3 transform_of(const std::vector<double>& v, const std::string& where) {
  Eigen::Matrix3d rotation;
  rotation << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  return Rigid3(checked_rotation(where, rotation), Eigen::Vector3d(v[3], v[7], v[11]));
}

}  // namespace

YAML::Node load_yaml_map(const std::string& path) {
  std::ifstream stream(path);
  std::ostringstream text;
  if (std::filesystem::is_directory(path) || !stream || !(text << stream.rdbuf())) {
    throw Error(fmt::format("{}: cannot be read", path));
  }
  YAML::Node root;
  try {
    std::string yaml = text.str();
    if (yaml.starts_with("%YAML:")) yaml.erase(0, yaml.find('\n'));  // OpenCV writes a directive that is no YAML
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw Error(fmt::format("{}: line {}: {}", path, error.mark.line + 1, error.msg));
  }
  if (!root.IsMap()) throw Error(fmt::format("{}: must be a group of keys", path));
  return root;
}

YAML::Node yaml_child(const YAML::Node& node, const std::string& key, const std::string& where) {
  if (!node.IsMap()) throw Error(fmt::format("{}: must be a group of keys", where));
  const YAML::Node child = node[key];
  if (!child) throw Error(fmt::format("{}: has no {}", where, key));
  return child;
}

double yaml_number(const YAML::Node& node, const std::string& where) {
  const std::optional<double> number = node.IsScalar() ? parse_double(node.Scalar()) : std::nullopt;
  if (!number || !std::isfinite(*number)) {
    throw Error(
        fmt::format("{}: not a finite number{}", where, node.IsScalar() ? ": " + in_quotes(node.Scalar()) : ""));
  }
  return *number;
}

double yaml_number_or(const YAML::Node& node, const std::string& key, double fallback, const std::string& where) {
  const YAML::Node child = node[key];
  return child ? yaml_number(child, where + "." + key) : fallback;
}

int yaml_int(const YAML::Node& node, const std::string& where) {
  const double number = yaml_number(node, where);
  if (number != std::floor(number) || std::abs(number) > 1e9) {
    throw Error(fmt::format("{}: not a whole number: {}", where, number));
  }
  return static_cast<int>(number);
}

std::string yaml_text(const YAML::Node& node, const std::string& where) {
  if (!node.IsScalar()) throw Error(fmt::format("{}: must be text", where));
  return node.Scalar();
}

std::vector<double> yaml_numbers(const YAML::Node& node, const std::string& where) {
  if (!node.IsSequence()) throw Error(fmt::format("{}: must be a list of numbers", where));
  std::vector<double> numbers;
  append_numbers(node, where, &numbers);
  return numbers;
}

Rigid3 yaml_matrix(const YAML::Node& node, const std::string& where) {
  const std::vector<double> numbers = yaml_numbers(node, where);
  if (numbers.size() != 12 && numbers.size() != 16) {
    throw Error(fmt::format("{}: a transform has 12 or 16 numbers, row by row, this has {}", where, numbers.size()));
  }
  return transform_of(numbers, where);
}

Rigid3 yaml_rotation_translation(const YAML::Node& rotation, const YAML::Node& translation, const std::string& where) {
  const std::vector<double> r = yaml_numbers(rotation, where);
  const std::vector<double> t = yaml_numbers(translation, where);
  if (r.size() != 9 || t.size() != 3) {
    throw Error(fmt::format("{}: {} and {} numbers instead of the 9 of a rotation and the 3 of a translation", where,
                            r.size(), t.size()));
  }
  return transform_of({r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2]}, where);
}

void check_yaml_keys(const YAML::Node& node, std::initializer_list<const char*> known, const std::string& where) {
  if (!node.IsMap()) throw Error(fmt::format("{}: must be a group of keys", where));
  for (const auto& entry : node) {
    const std::string key = yaml_text(entry.first, where);
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw Error(fmt::format("{}: unknown key '{}'", where, key));
    }
  }
}

}  // namespace cpplus
