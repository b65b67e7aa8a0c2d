#include "run_cpplus.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>

namespace cpplus {

namespace {

std::string output_stem() { return testing::TempDir() + "/cpplus_" + std::to_string(getpid()); }

}  // namespace

std::string stdout_file() { return output_stem() + ".out"; }
std::string stderr_file() { return output_stem() + ".err"; }

namespace {

std::string test_name() {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "." + test->name();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

[[noreturn]] void execute(const std::string& program, const std::vector<std::string>& arguments, const std::string& out,
                          const std::string& err) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(open(out.c_str(), kWrite, 0600), STDOUT_FILENO);
  dup2(open(err.c_str(), kWrite, 0600), STDERR_FILENO);
  execv(argv[0], argv.data());
  _exit(127);
}

/// `while_running` gets the process's number.
ProcessResult run(const std::string& program, const std::vector<std::string>& arguments,
                  const std::function<void(pid_t)>& while_running) {
  const std::string out = stdout_file();
  const std::string err = stderr_file();
  write_file(out, "");  // there even where the process is killed before it opens them
  write_file(err, "");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) execute(program, arguments, out, err);
  while_running(child);
  int status = 0;
  waitpid(child, &status, 0);
  ProcessResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = read_file(out);
  result.err = read_file(err);
  std::filesystem::remove(out);
  std::filesystem::remove(err);
  return result;
}

}  // namespace

ProcessResult run_program(const std::string& program, const std::vector<std::string>& arguments) {
  return run(program, arguments, [](pid_t) {});
}

ProcessResult run_cpplus(const std::vector<std::string>& arguments) { return run_program(CPPLUS_BINARY, arguments); }

ProcessResult run_cpplus_and_kill(const std::vector<std::string>& arguments, const std::function<void()>& moment,
                                  int signal) {
  // A process that has ended keeps its number until it is waited for, so nothing else can be hit.
  return run(CPPLUS_BINARY, arguments, [&moment, signal](pid_t child) {
    moment();
    kill(child, signal);
  });
}

ProcessResult run_well(const std::vector<std::string>& arguments) {
  ProcessResult result = run_cpplus(arguments);
  EXPECT_EQ(result.exit_code, 0) << testing::PrintToString(arguments);
  EXPECT_EQ(result.err, "") << testing::PrintToString(arguments);
  return result;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  if (!(stream << text)) throw std::runtime_error("cannot write " + path);
}

std::string make_test_directory() {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("cpplus." + test_name());
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path.string();
}

}  // namespace cpplus
