// Help, exit codes and configuration of the program, for every command it lists.
#include <gmock/gmock.h>

#include "run_cpplus.h"

namespace cpplus {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// The commands under "Subcommands:" in `cpplus --help`.
std::vector<std::string> command_names() {
  std::vector<std::string> names;
  bool listing = false;
  for (const std::string& line : lines_of(run_cpplus({"--help"}).out)) {
    if (listing && line.starts_with("  ")) names.push_back(line.substr(2, line.find(' ', 2) - 2));
    if (line == "Subcommands:") listing = true;
  }
  return names;
}

TEST(CommandLine, HelpOfEveryCommand) {
  const std::vector<std::string> names = command_names();
  EXPECT_THAT(names, testing::IsSupersetOf({"config"}));
  for (const std::string& name : names) {
    const ProcessResult help = run_cpplus({name, "--help"});
    EXPECT_EQ(help.exit_code, 0) << name;
    EXPECT_EQ(help.err, "") << name;
    for (const char* flag : {"--help", "--threads", "--quiet", "--config"})
      EXPECT_THAT(help.out, HasSubstr(flag)) << name;
  }
}

TEST(CommandLine, WrongUsageIsTwoAndOneLine) {
  const std::vector<std::vector<std::string>> wrong = {{},
                                                       {"nonsense"},
                                                       {"--nonsense"},
                                                       {"config"},
                                                       {"config", "dump", "--nonsense"},
                                                       {"config", "dump", "--threads", "many"},
                                                       {"config", "dump", "--threads", "-1"},
                                                       {"config", "dump", "--threads"},
                                                       {"config", "dump", "--quiet=false"},
                                                       {"config", "dump", "--config", "/missing.yaml"}};
  for (const auto& arguments : wrong) {
    const ProcessResult result = run_cpplus(arguments);
    EXPECT_EQ(result.exit_code, 2) << testing::PrintToString(arguments);
    EXPECT_EQ(result.out, "") << testing::PrintToString(arguments);
    EXPECT_THAT(lines_of(result.err), ElementsAre(StartsWith("cpplus: "))) << testing::PrintToString(arguments);
  }
}

TEST(CommandLine, EveryCommandWithoutItsInputsIsWrongUsage) {
  for (const std::string& name : command_names()) {
    const ProcessResult result = run_cpplus({name});
    EXPECT_EQ(result.exit_code, 2) << name;
    EXPECT_THAT(lines_of(result.err), ElementsAre(StartsWith("cpplus: "))) << name;
  }
}

TEST(CommandLine, VersionIsOneLine) {
  const ProcessResult result = run_cpplus({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(lines_of(result.out), ElementsAre(testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+")));
}

TEST(Config, DumpReadsBackToItself) {
  const std::string directory = make_test_directory();
  const ProcessResult dump = run_cpplus({"config", "dump"});
  ASSERT_EQ(dump.exit_code, 0) << dump.err;
  write_file(directory + "/all.yaml", dump.out);
  const ProcessResult again = run_cpplus({"config", "dump", "--config", directory + "/all.yaml"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, dump.out);
}

TEST(Config, FileSetsAndFlagWins) {
  const std::string file = make_test_directory() + "/threads.yaml";
  write_file(file, "threads: 3\nquiet: true\n");
  const ProcessResult from_file = run_cpplus({"config", "dump", "--config", file});
  EXPECT_THAT(from_file.out, HasSubstr("\nthreads: 3\n"));
  EXPECT_THAT(from_file.out, HasSubstr("\nquiet: true\n"));
  const ProcessResult from_flag = run_cpplus({"config", "dump", "--threads", "1", "--no-quiet", "--config", file});
  EXPECT_THAT(from_flag.out, HasSubstr("\nthreads: 1\n"));
  EXPECT_THAT(from_flag.out, HasSubstr("\nquiet: false\n"));
}

TEST(Config, UnknownKeyAndWrongTypeNameFileAndKey) {
  const std::string file = make_test_directory() + "/bad.yaml";
  const auto error_of = [&](const std::string& yaml) {
    write_file(file, yaml);
    const ProcessResult result = run_cpplus({"config", "dump", "--config", file});
    EXPECT_EQ(result.exit_code, 2) << yaml;
    EXPECT_EQ(result.out, "") << yaml;
    return result.err;
  };
  EXPECT_EQ(error_of("thread: 3\n"), "cpplus: " + file + ": unknown key 'thread'\n");
  EXPECT_EQ(error_of("threads: few\n"), "cpplus: " + file + ": threads must be a whole number, got 'few'\n");
  EXPECT_EQ(error_of("threads: [1, 2]\n"), "cpplus: " + file + ": threads must be a whole number, got a list\n");
}

}  // namespace
}  // namespace cpplus
