#pragma once

#include <stdexcept>
#include <string>

namespace cpplus {

/// Bad input: the message is one line that names the file or field and the offending value.
/// Only the boundaries throw it (readers, option validation); stages report expected outcomes as a status.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

/// Wrong usage of the command line or of the configuration: the program ends with exit code 2, not 1.
class UsageError : public Error {
 public:
  using Error::Error;
};

}  // namespace cpplus
