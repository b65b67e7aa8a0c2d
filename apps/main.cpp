#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <string>

#include "commands.h"
#include "cpplus/core/error.h"
#include "cpplus/core/interrupt.h"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kInterrupted = 130;  // 128 + SIGINT

/// Prints the message as one line, whatever it holds.
int fail(std::string message, int exit_code) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  fmt::print(stderr, "cpplus: {}\n", message);
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  cpplus::stop_on_signals();
  try {
    cpplus::CommandLine command_line;
    cpplus::add_adjust_command(&command_line);
    cpplus::add_clean_command(&command_line);
    cpplus::add_colorize_command(&command_line);
    cpplus::add_evaluate_command(&command_line);
    cpplus::add_export_command(&command_line);
    cpplus::add_import_command(&command_line);
    cpplus::add_poses_command(&command_line);
    cpplus::add_refine_command(&command_line);
    cpplus::add_report_command(&command_line);
    cpplus::add_run_command(&command_line);
    cpplus::add_index_command(&command_line);
    cpplus::add_info_command(&command_line);
    cpplus::add_simulate_command(&command_line);
    cpplus::add_view_command(&command_line);
    cpplus::add_config_command(&command_line);
    return command_line.run(argc, argv);
  } catch (const cpplus::UsageError& error) {
    return fail(error.what(), kWrongUsage);
  } catch (const cpplus::Interrupted& interrupted) {
    return fail(interrupted.what(), kInterrupted);
  } catch (const std::bad_alloc&) {
    return fail("out of memory", kFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kFailed);
  }
}
