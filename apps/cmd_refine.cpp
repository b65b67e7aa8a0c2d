#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/refine_command.h"

namespace cpplus {
namespace {

void run_refine(const RefineCommandOptions& options) {
  const RefineSummary summary = refine_command(options);
  log_info(
      fmt::format("{}: {} of {} images refined, {} kept as they were, {} blurred, {} outside the map, {} unreadable",
                  options.out, summary.num_refined, summary.num_images, summary.num_kept_coarse, summary.num_blurred,
                  summary.num_outside_map, summary.num_unreadable));
}

}  // namespace

void add_refine_command(CommandLine* command_line) {
  command_line->add_command<RefineCommandOptions>("refine", "Aligns images with the map: coarse poses to refined poses",
                                                  run_refine);
}

}  // namespace cpplus
