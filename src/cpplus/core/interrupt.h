#pragma once

#include <stdexcept>
#include <string>

namespace cpplus {

/// The user asked the program to stop (Ctrl-C). Ends with exit code 130, as shells have it.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(const std::string& message = "interrupted") : std::runtime_error(message) {}
};

/// Asks for a stop; safe in a signal handler.
void request_interrupt() noexcept;
bool interrupt_requested() noexcept;
/// Throws Interrupted where a stop was asked for. Loops over heavy items (core/parallel.h) do so before each of them.
void check_interrupt();

/// From now on the first SIGINT or SIGTERM asks for a stop; the next one ends the program at once.
void stop_on_signals();

/// Takes the request back: for what must still be written, and for tests.
void clear_interrupt() noexcept;

}  // namespace cpplus
