#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cpplus/core/option_list.h"

namespace cpplus {

/// Sets the fields that the YAML file names; a field "refine.map" is the key `map` inside the key `refine`. Fields that
/// the file does not name keep their value. Throws UsageError, naming file and key, for a file that cannot be read or
/// is not YAML, an unknown or repeated key, and a value of the wrong type.
void read_options_yaml(const std::filesystem::path& file, const std::vector<OptionField>& fields);

/// The fields as YAML that read_options_yaml reads back, each below its doc as a comment. Fields of a group must be
/// consecutive, as list_options gives them.
std::string options_to_yaml(const std::vector<OptionField>& fields);

}  // namespace cpplus
