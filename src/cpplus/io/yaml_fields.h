#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "cpplus/geometry/rigid3.h"

namespace YAML {
class Node;
}

namespace cpplus {

// Fields of YAML files of sensors. `where` names file and place ("rig.yaml: cameras.front") at the beginning of the
// messages of the Error that each of these throws for what is not of its type.

/// The root of the file, which must be a group of keys; comments and "%YAML" lines of OpenCV may stand before.
YAML::Node load_yaml_map(const std::string& path);

/// The value of a key that must be there.
YAML::Node yaml_child(const YAML::Node& node, const std::string& key, const std::string& where);

double yaml_number(const YAML::Node& node, const std::string& where);
/// The number of a key, or the fallback where there is no such key.
double yaml_number_or(const YAML::Node& node, const std::string& key, double fallback, const std::string& where);
int yaml_int(const YAML::Node& node, const std::string& where);
std::string yaml_text(const YAML::Node& node, const std::string& where);
/// The numbers of a list, or of a list of lists one after the other.
std::vector<double> yaml_numbers(const YAML::Node& node, const std::string& where);

/// A transform from 12 or 16 numbers, the rows of its matrix.
Rigid3 yaml_matrix(const YAML::Node& node, const std::string& where);
/// A transform from two lists: 9 numbers of the rotation's rows, 3 of the translation.
Rigid3 yaml_rotation_translation(const YAML::Node& rotation, const YAML::Node& translation, const std::string& where);

/// Throws Error naming the first key that is not in the list.
void check_yaml_keys(const YAML::Node& node, std::initializer_list<const char*> known, const std::string& where);

}  // namespace cpplus
