#include "cpplus/pipeline/run_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
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

/// Options that are paths of what the command of a step writes.
bool is_output(const RunStep& step, const OptionField& field) {
  const std::string name = last_part(field.path);
  if (step.name == "adjust" && name == "map") return true;
  return text_of(field) && (name == "out" || name == "labels" || name == "debug_images");
}

/// The texts of the output options that are given, "out" among them or nothing at all.
std::vector<std::string> outputs_of(const RunStep& step) {
  std::vector<std::string> outputs;
  bool has_out = false;
  for (const OptionField& field : step.fields) {
    if (!is_output(step, field) || text_of(field)->empty()) continue;
    outputs.push_back(*text_of(field));
    has_out = has_out || last_part(field.path) == "out";
  }
  return has_out ? outputs : std::vector<std::string>{};
}

/// A folder that a command fills for itself, and whose content changes no result.
bool is_cache(const OptionField& field) { return last_part(field.path) == "cache"; }

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
    if (!text || text->empty() || is_output(step, field) || is_cache(field)) continue;
    if (fs::exists(*text)) inputs += "input " + describe(*text);
  }
  return options + inputs;
}

/// The outputs, a line a file as describe() gives it.
std::vector<std::string> result_of(const RunStep& step) {
  std::vector<std::string> lines;
  for (const std::string& output : outputs_of(step)) {
    std::istringstream text(describe(output));
    for (std::string line; std::getline(text, line);) lines.push_back("output " + line);
  }
  return lines;
}

std::string read_text(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Whether the step was done with these causes and all that it made is still there. Files that came later, such as
/// what a later step writes into the same folder, do not matter.
bool is_done(const RunStep& step, const fs::path& done, const std::string& causes) {
  if (!fs::exists(done)) return false;
  const std::string text = read_text(done);
  if (!text.starts_with(causes)) return false;
  const std::vector<std::string> now = result_of(step);
  const std::set<std::string> there(now.begin(), now.end());
  std::istringstream made(text.substr(causes.size()));
  for (std::string line; std::getline(made, line);) {
    const std::string name = line.substr(0, line.rfind(": ") + 2);
    const auto same = step.output_may_be_edited ? there.lower_bound(name) : there.find(line);
    if (same == there.end() || !same->starts_with(name) || same->ends_with(": none")) return false;
  }
  return true;
}

void make_anew(const RunStep& step, const fs::path& done, const std::string& causes) {
  std::error_code failure;
  fs::remove(done, failure);
  if (failure) throw Error(fmt::format("{}: cannot be removed: {}", done.string(), failure.message()));
  for (const std::string& output : outputs_of(step)) remove_leftovers(output);
  step.run();
  write_text_file(done.string(), fmt::format("{}{}\n", causes, fmt::join(result_of(step), "\n")));
}

}  // namespace

std::vector<StepOutcome> run_steps(const std::vector<RunStep>& steps, const std::string& state_folder) {
  std::vector<StepOutcome> outcomes;
  for (const RunStep& step : steps) {
    if (outputs_of(step).empty()) continue;
    const fs::path done = fs::path(state_folder) / (step.name + ".done");
    StepOutcome outcome;
    outcome.name = step.name;
    const std::string causes = causes_of(step);  // before the run, so that a change during it is not overlooked
    outcome.was_skipped = is_done(step, done, causes);
    if (!outcome.was_skipped) {
      const Stopwatch watch;
      make_anew(step, done, causes);
      outcome.seconds = watch.milliseconds() / 1000.0;
    }
    outcomes.push_back(outcome);
  }
  return outcomes;
}

}  // namespace cpplus
