#pragma once

#include <string>

namespace cpplus {

/// Throws Error where a point cloud cannot be written to the path, so that a command fails before its work rather than
/// after it: unknown extension, or no way to make the file.
void check_cloud_output(const std::string& path);

}  // namespace cpplus
