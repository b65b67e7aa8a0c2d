// Runs every row of docs/bad_input.md: exit code and message must be what the table says.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bad_input_cases.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

struct Row {
  std::string name;
  std::string command;
  int exit_code = 0;
  std::string message;  // DIR stands for the folder of the scene
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  size_t begin = 1;
  for (size_t end; (end = line.find(" |", begin)) != std::string::npos; begin = end + 2) {
    const size_t first = line.find_first_not_of(' ', begin);
    cells.push_back(first >= end ? "" : line.substr(first, end - first));
  }
  return cells;
}

/// "`text`" or "`` text ``" -> "text".
std::string unquoted(const std::string& code) {
  const size_t quotes = code.starts_with("`` ") ? 3 : 1;
  return code.size() < 2 * quotes ? "" : code.substr(quotes, code.size() - 2 * quotes);
}

/// The rows of the tables: what is wrong, command, exit code, message.
std::vector<Row> table_rows() {
  std::vector<Row> rows;
  for (const std::string& line : lines_of(read_file(CPPLUS_DOCS_DIR "/bad_input.md"))) {
    if (!line.starts_with("| ")) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != 4 || !cells[1].starts_with("`")) continue;
    rows.push_back({cells[0], unquoted(cells[1]), std::stoi(cells[2]), unquoted(cells[3])});
  }
  return rows;
}

std::string replace_all(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string test_name(const testing::TestParamInfo<Row>& info) {
  std::string name = info.param.name;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

void PrintTo(const Row& row, std::ostream* stream) { *stream << row.name; }

/// "report.json: NAME: STATUS" for each image of DIR/out/report.json, where there is one.
std::vector<std::string> status_lines(const TinyScene& scene) {
  std::vector<std::string> lines;
  const std::string file = scene.path("out/report.json");
  if (!std::filesystem::exists(file)) return lines;
  const nlohmann::json report = nlohmann::json::parse(read_file(file));
  for (const auto& image : report["images"]) {
    lines.push_back(
        fmt::format("report.json: {}: {}", image["name"].get<std::string>(), image["status"].get<std::string>()));
  }
  return lines;
}

class BadInput : public testing::TestWithParam<Row> {};

TEST_P(BadInput, EndsAsTheTableSays) {
  const Row& row = GetParam();
  const std::map<std::string, BadInputCase> cases = bad_input_cases();
  ASSERT_EQ(cases.count(row.name), 1u) << "docs/bad_input.md has a row without a case";
  ASSERT_NE(row.message, "") << "a row without a message accepts everything";
  const TinyScene scene(make_test_directory());
  const std::vector<std::string> arguments = cases.at(row.name)(scene);
  EXPECT_EQ(arguments.at(0), row.command);

  const ProcessResult result = run_cpplus(arguments);
  const std::string err = replace_all(result.err, scene.directory(), "DIR");
  const std::string out = replace_all(result.out, scene.directory(), "DIR");
  EXPECT_EQ(result.exit_code, row.exit_code) << err;
  if (row.exit_code != 0) {
    std::vector<std::string> lines = lines_of(err);
    ASSERT_FALSE(lines.empty());
    EXPECT_EQ(lines.back(), row.message);
    lines.pop_back();
    EXPECT_THAT(lines, testing::Each(testing::StartsWith("warning: ")));
    EXPECT_FALSE(std::filesystem::exists(scene.path("out"))) << "something was written";
    EXPECT_FALSE(std::filesystem::exists(scene.path("out.ply"))) << "something was written";
  } else {
    std::vector<std::string> lines = lines_of(err + out);
    for (const std::string& line : status_lines(scene)) lines.push_back(line);
    EXPECT_THAT(lines, testing::Contains(testing::EndsWith(row.message)));
  }
}

INSTANTIATE_TEST_SUITE_P(Table, BadInput, testing::ValuesIn(table_rows()), test_name);

TEST(BadInputTable, HasARowForEveryCase) {
  std::map<std::string, int> rows;
  for (const Row& row : table_rows()) ++rows[row.name];
  for (const auto& [name, count] : rows) EXPECT_EQ(count, 1) << name;
  for (const auto& [name, spoil] : bad_input_cases()) EXPECT_EQ(rows.count(name), 1u) << name;
  EXPECT_GE(rows.size(), 25u);
}

TEST(TinyScene, IsGoodBeforeItIsSpoilt) {
  const TinyScene scene(make_test_directory());
  const std::string model = scene.path("model");
  for (const auto& arguments : {scene.colorize(),
                                scene.clean(),
                                scene.poses(),
                                with_flag(scene.exports("3dgs"), "--out", scene.path("exported")),
                                {"info", scene.directory()},
                                {"evaluate", "--estimate", model, "--reference", model}}) {
    const ProcessResult result = run_cpplus(arguments);
    EXPECT_EQ(result.exit_code, 0) << arguments[0];
    EXPECT_EQ(result.err, "") << arguments[0];
  }
}

TEST(TinyScene, HasAGoodResultBeforeItIsSpoilt) {
  const TinyScene scene(make_test_directory());
  const std::string result = scene.path("result");
  for (const auto& arguments : {with_flag(scene.refine(), "--out", result),
                                {"report", result},
                                with_flag(scene.colorize(), "--out", scene.path("result/coloured.ply")),
                                {"view", result, "--export", scene.path("view")}}) {
    const ProcessResult run = run_cpplus(arguments);
    EXPECT_EQ(run.exit_code, 0) << arguments[0];
    EXPECT_EQ(run.err, "") << arguments[0];
  }
}

}  // namespace
}  // namespace cpplus
