#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/clean_command.h"

namespace cpplus {

void add_clean_command(CommandLine* command_line) {
  command_line->add_command<CleanCommandOptions>(
      "clean", "Makes a map of what stands still from scans with poses", [](const CleanCommandOptions& options) {
        const CleanSummary summary = run_clean(options);
        const double percent =
            100.0 * static_cast<double>(summary.num_dynamic) / static_cast<double>(summary.num_points);
        log_info(fmt::format("{}: kept {} of {} points, left {} dynamic ones ({:.1f} %) out; scans: {}", options.out,
                             summary.num_points - summary.num_dynamic, summary.num_points, summary.num_dynamic, percent,
                             summary.num_scans));
      });
}

}  // namespace cpplus
