#include "cpplus/pipeline/run_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "cpplus/core/error.h"
#include "cpplus/core/stopwatch.h"
#include "cpplus/core/version.h"
#include "cpplus/io/atomic_file.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

std::string last_part(const std::string& path) { return path.substr(path.find_last_of('.') + 1); }

const std::string* text_of(const OptionField& field) {
  const auto* text = std::get_if<std::string*>(&field.value);
  return text ? *text : nullptr;
}

/// Whether the step writes what the field names.
bool is_output(const RunStep& step, const OptionField& field) {
  const std::string name = last_part(field.path);
  return name == "out" || (step.name == "adjust" && name == "map");
}

/// The text of the field "out"; "" where the step has none.
std::string output_of(const RunStep& step) {
  for (const OptionField& field : step.fields) {
    const std::string* text = text_of(field);
    if (text && last_part(field.path) == "out") return *text;
  }
  return "";
}

std::string describe_file(const fs::path& path) {
  std::error_code failure;
  const uintmax_t size = fs::file_size(path, failure);
  const auto time = fs::last_write_time(path, failure).time_since_epoch().count();
  return failure ? "gone" : fmt::format("{} bytes, {}", size, time);
}

/// What a file or folder is at this moment, one line a file.
std::string describe(const std::string& path) {
  if (!fs::exists(path)) return fmt::format("{}: none\n", path);
  if (!fs::is_directory(path)) return fmt::format("{}: {}\n", path, describe_file(path));
  std::vector<std::string> lines;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file())
      lines.push_back(fmt::format("{}: {}\n", entry.path().string(), describe_file(entry.path())));
  }
  std::sort(lines.begin(), lines.end());
  std::string text = fmt::format("{}: folder\n", path);
  for (const std::string& line : lines) text += line;
  return text;
}

/// Everything that the result of a step depends on.
std::string causes_of(const RunStep& step) {
  std::string options = fmt::format("version: {}\n", version());
  std::string inputs;
  for (const OptionField& field : step.fields) {
    options += fmt::format("{}: {}\n", field.path, option_text(field));
    const std::string* text = text_of(field);
    if (text && !text->empty() && !is_output(step, field) && fs::exists(*text)) inputs += "input " + describe(*text);
  }
  return options + inputs;
}

std::string result_of(const RunStep& step) { return "output " + describe(output_of(step)); }

std::string read_text(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

std::vector<StepOutcome> run_steps(const std::vector<RunStep>& steps, const std::string& state_folder) {
  std::vector<StepOutcome> outcomes;
  for (const RunStep& step : steps) {
    if (output_of(step).empty()) continue;
    const fs::path done = fs::path(state_folder) / (step.name + ".done");
    StepOutcome outcome;
    outcome.name = step.name;
    const std::string causes = causes_of(step);  // before the run, so that a change during it is not overlooked
    outcome.was_skipped = fs::exists(done) && read_text(done) == causes + result_of(step);
    if (!outcome.was_skipped) {
      std::error_code failure;
      fs::remove(done, failure);
      if (failure) throw Error(fmt::format("{}: cannot be removed: {}", done.string(), failure.message()));
      const Stopwatch watch;
      step.run();
      outcome.seconds = watch.milliseconds() / 1000.0;
      write_text_file(done.string(), causes + result_of(step));
    }
    outcomes.push_back(outcome);
  }
  return outcomes;
}

}  // namespace cpplus
