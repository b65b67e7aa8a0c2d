#pragma once

#include <string>

namespace cpplus {

/// How an options struct shows its fields to YAML, the command line and `config dump`: each struct has
///
///   template <typename Visitor>
///   void visit(Visitor& visitor) {
///     visitor("max_distance_m", max_distance_m, "Roots farther than this from the camera are not looked at. (0, inf)");
///   }
///
/// with one line a field, in the order of the declaration. Field types: bool, int, double, std::string. Nested
/// structs are visited with visitor.group("name", nested). The visitors live in apps/ and io/.

/// Throws Error "NAME must be in RANGE, got VALUE" unless ok.
void check_option(bool ok, const char* name, const char* range, double value);

/// Throws UsageError "option NAME is required" if the value is empty.
void require_option(const char* name, const std::string& value);

}  // namespace cpplus
