#pragma once

#include <string>
#include <vector>

namespace cpplus {

/// Reads fields of a PCD file (ascii or binary) that are no attributes of points, as doubles: one list a name, in the
/// order of the names. Throws Error for a field that is missing or is no single number, and for a compressed file.
std::vector<std::vector<double>> read_pcd_columns(const std::string& path, const std::vector<std::string>& names);

}  // namespace cpplus
