#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/export_command.h"

namespace cpplus {

void add_export_command(CommandLine* command_line) {
  command_line->add_command<ExportCommandOptions>(
      "export", "Writes poses, images and map for other programs", [](const ExportCommandOptions& options) {
        const ExportSummary summary = run_export(options);
        log_info(fmt::format("{}: {}: {} images ({} skipped), {} points, {} observations", options.out, options.format,
                             summary.num_images, summary.num_skipped, summary.num_points, summary.num_observations));
      });
}

}  // namespace cpplus
