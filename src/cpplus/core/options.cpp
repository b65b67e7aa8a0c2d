#include "cpplus/core/options.h"

#include <fmt/format.h>

#include "cpplus/core/error.h"

namespace cpplus {

void check_option(bool ok, const char* name, const char* range, double value) {
  if (!ok) throw UsageError(fmt::format("option {} must be in {}, got {}", name, range, value));
}

void require_option(const char* name, const std::string& value) {
  if (value.empty()) throw UsageError(fmt::format("option {} is required", name));
}

}  // namespace cpplus
