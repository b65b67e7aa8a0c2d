#pragma once

#include <csignal>
#include <functional>
#include <string>
#include <vector>

namespace cpplus {

struct ProcessResult {
  int exit_code = -1;  // 128 + signal where one ended the process
  std::string out;
  std::string err;
};

/// Runs a program, given by its path, without a shell and without a terminal.
ProcessResult run_program(const std::string& program, const std::vector<std::string>& arguments);

/// Starts the built program and sends it a signal (SIGKILL) when `moment` returns, unless it ended before.
ProcessResult run_cpplus_and_kill(const std::vector<std::string>& arguments, const std::function<void()>& moment,
                                  int signal = SIGKILL);

/// The files that the output of the running program goes to, for a `moment` that waits for a line of it.
std::string stdout_file();
std::string stderr_file();

/// Runs the built program with these arguments.
ProcessResult run_cpplus(const std::vector<std::string>& arguments);

/// The same, expecting it to succeed without a word on the standard error.
ProcessResult run_well(const std::vector<std::string>& arguments);

/// The lines of a text, without their ends.
std::vector<std::string> lines_of(const std::string& text);

std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& text);

/// An empty folder of its own for the running test, below the test's temporary folder.
std::string make_test_directory();

}  // namespace cpplus
