#include "cpplus/core/log.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>

namespace cpplus {

namespace {

std::atomic<bool> quiet_{false};

}  // namespace

void set_quiet(bool quiet) { quiet_ = quiet; }
bool is_quiet() { return quiet_; }

void log_info(const std::string& line) {
  if (quiet_) return;
  fmt::print(stdout, "{}\n", line);
  std::fflush(stdout);
}

void log_warning(const std::string& line) { fmt::print(stderr, "warning: {}\n", line); }

}  // namespace cpplus
