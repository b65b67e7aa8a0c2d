#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/colorize_command.h"

namespace cpplus {

void add_colorize_command(CommandLine* command_line) {
  command_line->add_command<ColorizeCommandOptions>(
      "colorize", "Colours a map from images with poses", [](const ColorizeCommandOptions& options) {
        const ColorizeSummary summary = run_colorize(options);
        log_info(fmt::format("{}: {} of {} points coloured ({:.1f} %) from {} images, {} images skipped", options.out,
                             summary.num_colored, summary.num_points,
                             100.0 * static_cast<double>(summary.num_colored) / static_cast<double>(summary.num_points),
                             summary.num_images, summary.num_skipped));
      });
}

}  // namespace cpplus
