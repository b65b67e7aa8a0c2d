#pragma once

namespace cpplus {

/// The version of the project, as in CMakeLists.txt.
const char* version();

}  // namespace cpplus
