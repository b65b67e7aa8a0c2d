#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cpplus/core/option_list.h"

namespace cpplus {

/// A command as a step of a longer run.
struct RunStep {
  std::string name;
  /// Its options. A text that is the path of a file or folder counts as an input, but for the outputs: those of the
  /// fields "out", "labels" and "debug_images".
  std::vector<OptionField> fields;
  std::function<void()> run;
  /// What it made may be changed by hand afterwards; else it is made anew then.
  bool output_may_be_edited = false;
};

struct StepOutcome {
  std::string name;
  bool was_skipped = false;  // nothing had changed since it was run last
  double seconds = 0.0;
};

/// Runs the steps whose "out" is given, in their order, but skips one whose options, inputs, output and program version
/// are as they were when it was last done. Files are compared by size and time of change, folders by those of all their
/// files; in the output only those files count that the step made.
///
/// What a step was done with stands in STATE/NAME.done, written once its output is there and removed before it is made
/// anew: a run that is killed at any moment goes on with the step that it was in. Throws what a step throws.
std::vector<StepOutcome> run_steps(const std::vector<RunStep>& steps, const std::string& state_folder);

}  // namespace cpplus
