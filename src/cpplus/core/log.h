#pragma once

#include <string>

namespace cpplus {

/// With quiet on, log_info and progress bars are silent; warnings still appear. Off at the start.
void set_quiet(bool quiet);
bool is_quiet();

/// One line on stdout: what was done and how much of it. For pipeline/ and apps/; stages do not print.
void log_info(const std::string& line);

/// One line on stderr, "warning: LINE": the run goes on, but the user should know.
void log_warning(const std::string& line);

}  // namespace cpplus
