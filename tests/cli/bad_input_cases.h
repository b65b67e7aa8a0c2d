#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tiny_scene.h"

namespace cpplus {

/// Spoils a good scene in one way and returns the arguments to run the program with.
using BadInputCase = std::function<std::vector<std::string>(const TinyScene&)>;

/// By the first column of docs/bad_input.md.
std::map<std::string, BadInputCase> bad_input_cases();

/// Those of voxel map files.
std::map<std::string, BadInputCase> bad_voxel_map_cases();

/// Those of them that spoil a result of `refine`.
std::map<std::string, BadInputCase> bad_result_cases();

}  // namespace cpplus
