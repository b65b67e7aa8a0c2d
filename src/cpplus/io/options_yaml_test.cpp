#include "cpplus/io/options_yaml.h"

#include <gtest/gtest.h>

#include <fstream>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

struct SearchOptions {
  double radius_px = 12.5;
  bool check_direction = true;

  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("radius_px", radius_px, "Search radius, px.");
    visitor("check_direction", check_direction, "Compare directions.");
  }
};

struct TestOptions {
  std::string map;
  SearchOptions search;
  int rounds = 3;

  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("map", map, "The map.");
    visitor.group("search", search);
    visitor("rounds", rounds, "Outer iterations.");
  }
};

class OptionsYaml : public testing::Test {
 protected:
  void write(const std::string& yaml) { std::ofstream(file_) << yaml; }
  void read() { read_options_yaml(file_, list_options(options_, "refine")); }
  /// The error's message behind "FILE: ", or "accepted".
  std::string error_of(const std::string& yaml) {
    write(yaml);
    try {
      read();
    } catch (const UsageError& error) {
      const std::string message = error.what();
      const std::string start = file_.string() + ": ";
      EXPECT_TRUE(message.starts_with(start)) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message.substr(start.size());
    }
    return "accepted";
  }

  std::filesystem::path file_ = std::filesystem::path(testing::TempDir()) /
                                (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".yaml");
  TestOptions options_;
};

TEST_F(OptionsYaml, DumpsDocsAndValues) {
  options_.map = "a \"b\"\n";
  EXPECT_EQ(options_to_yaml(list_options(options_, "refine")),
            "refine:\n"
            "  # The map.\n"
            "  map: \"a \\\"b\\\"\\n\"\n"
            "  search:\n"
            "    # Search radius, px.\n"
            "    radius_px: 12.5\n"
            "    # Compare directions.\n"
            "    check_direction: true\n"
            "  # Outer iterations.\n"
            "  rounds: 3\n");
}

TEST_F(OptionsYaml, ReadsBackWhatItDumps) {
  options_.map = "dir/with: colon #1";
  options_.search = {0.1 + 0.2, false};
  options_.rounds = -5;
  write(options_to_yaml(list_options(options_, "refine")));
  const TestOptions expected = options_;
  options_ = TestOptions();
  read();
  EXPECT_EQ(options_.map, expected.map);
  EXPECT_EQ(options_.search.radius_px, expected.search.radius_px);
  EXPECT_FALSE(options_.search.check_direction);
  EXPECT_EQ(options_.rounds, -5);
}

TEST_F(OptionsYaml, KeepsWhatTheFileDoesNotName) {
  for (const char* yaml :
       {"", "# only a comment\n", "refine:\n", "refine:\n  search:\n", "refine: {search: {radius_px: 12.5}}"}) {
    EXPECT_EQ(error_of(yaml), "accepted") << yaml;
    EXPECT_EQ(options_.rounds, 3);
    EXPECT_EQ(options_.search.radius_px, 12.5);
  }
}

TEST_F(OptionsYaml, RejectsNamingFileAndKey) {
  EXPECT_EQ(error_of("refine: {round: 4}"), "unknown key 'refine.round'");
  EXPECT_EQ(error_of("rounds: 4"), "unknown key 'rounds'");
  EXPECT_EQ(error_of("refine: {search: {rounds: 4}}"), "unknown key 'refine.search.rounds'");
  EXPECT_EQ(error_of("refine: {rounds: 4.5}"), "refine.rounds must be a whole number, got '4.5'");
  EXPECT_EQ(error_of("refine: {rounds: [4]}"), "refine.rounds must be a whole number, got a list");
  EXPECT_EQ(error_of("refine: {rounds: }"), "refine.rounds must be a whole number, got nothing");
  EXPECT_EQ(error_of("refine: {rounds: {a: 1}}"), "refine.rounds must be a whole number, got a group of keys");
  EXPECT_EQ(error_of("refine: {search: {check_direction: 1}}"),
            "refine.search.check_direction must be true or false, got '1'");
  EXPECT_EQ(error_of("refine: {search: 3}"), "'refine.search' must be a group of keys");
  EXPECT_EQ(error_of("refine: {rounds: 1, rounds: 2}"), "key 'refine.rounds' is given twice");
  EXPECT_EQ(error_of("- refine"), "must be a group of keys");
  EXPECT_EQ(error_of("refine: {rounds: 1\nmap: 2"), "line 2: end of map flow not found");
}

TEST_F(OptionsYaml, RejectsAFileThatCannotBeRead) {
  const std::vector<OptionField> fields = list_options(options_);
  EXPECT_THROW(read_options_yaml(testing::TempDir() + "/missing.yaml", fields), UsageError);
  EXPECT_THROW(read_options_yaml(testing::TempDir(), fields), UsageError);
}

}  // namespace
}  // namespace cpplus
