#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/error.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/run_steps.h"

namespace cpplus {

namespace {

/// A project is there to be worked on: an import done again keeps what it did not make, and one that was completed
/// keeps what was changed by hand.
RunStep import_for_run(RunStep step) {
  for (const OptionField& field : step.fields) {
    if (field.path == "import.replace") *std::get<bool*>(field.value) = true;
  }
  step.output_may_be_edited = true;
  return step;
}

}  // namespace

void add_run_command(CommandLine* command_line) {
  const auto run = [command_line] {
    if (command_line->config().empty()) throw UsageError("option config is required: it says what to run");
    std::vector<RunStep> steps;
    for (const char* name : {"import", "adjust", "clean", "poses", "refine", "colorize"}) {
      if (command_line->has_command(name)) steps.push_back(command_line->step(name));
      if (!steps.empty() && steps.back().name == "import") steps.back() = import_for_run(steps.back());
    }
    const std::vector<StepOutcome> outcomes = run_steps(steps, command_line->config() + ".state");
    if (outcomes.empty())
      throw UsageError(fmt::format("{}: no section of a step has an 'out'", command_line->config()));
    for (const StepOutcome& outcome : outcomes) {
      log_info(outcome.was_skipped ? fmt::format("{}: up to date", outcome.name)
                                   : fmt::format("{}: done in {:.1f} s", outcome.name, outcome.seconds));
    }
  };
  command_line->add_command(
      "run", "Runs import, adjust, clean, poses, refine and colorize as a --config file says, resumable", run);
}

}  // namespace cpplus
