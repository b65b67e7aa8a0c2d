#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/core/options.h"
#include "cpplus/pipeline/write_world.h"

namespace cpplus {

namespace {

struct SimulateCommandOptions {
  /// Folder for the world. Required.
  std::string out;
  SimulateOptions simulate;

  void validate() const {
    require_option("out", out);
    simulate.validate();
  }
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("out", out, "Folder for the world. Required.");
    simulate.visit(visitor);
  }
};

void run(const SimulateCommandOptions& options) {
  const SimulationSummary summary = simulate(options.simulate, options.out);
  log_info(fmt::format("{}: {} images, {} scans, {} map points, {} checkerboards, {} true edges", options.out,
                       summary.images, summary.scans, summary.map_points, summary.checkerboards, summary.true_edges));
}

}  // namespace

void add_simulate_command(CommandLine* command_line) {
  command_line->add_command<SimulateCommandOptions>("simulate", "Makes a world with exact truth", run);
}

}  // namespace cpplus
