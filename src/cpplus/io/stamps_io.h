#pragma once

#include <map>
#include <string>

namespace cpplus {

/// Reads image stamps: lines `name seconds`; the last word is the number, so that names may contain blanks; '#' starts
/// a comment line. Throws Error naming file, line and value for anything else, for a name that occurs twice and for a
/// file without stamps.
std::map<std::string, double> read_stamps(const std::string& path);

}  // namespace cpplus
