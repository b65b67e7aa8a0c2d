#include <fmt/format.h>

#include "commands.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/pipeline/evaluate_command.h"

namespace cpplus {

namespace {

struct EvaluateCommandOptions {
  EvaluateOptions evaluate;
  /// File for the figures as JSON; "" = none.
  std::string json;

  void validate() const { evaluate.validate(); }
  template <typename Visitor>
  void visit(Visitor& visitor) {
    evaluate.visit(visitor);
    visitor("json", json, "File for the figures as JSON; empty = none.");
  }
};

void run(const EvaluateCommandOptions& options) {
  const ModelComparison comparison = evaluate_models(options.evaluate);
  if (!options.json.empty()) write_text_file(options.json, comparison_json(comparison));
  fmt::print("{}", comparison_table(comparison));
}

}  // namespace

void add_evaluate_command(CommandLine* command_line) {
  command_line->add_command<EvaluateCommandOptions>("evaluate", "Compares poses with a reference", run);
}

}  // namespace cpplus
